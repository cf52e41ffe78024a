// Scenes of a few small meshes, three cycles on one detector, each held against brute force.
#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <string>

#include "byte_source.h"
#include "core/cpu_detector.h"
#include "detector_check.h"
#include "fuzz_target.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kCycles = 3;
constexpr std::size_t kMostBodies = 4, kMostVertices = 16, kMostTriangles = 16;

// Indices may be one beyond the last.
TriangleMesh meshFrom(ByteSource* source) {
  TriangleMesh mesh;
  mesh.vertices.resize(3 * source->below(kMostVertices + 1));
  for (float& coordinate : mesh.vertices) coordinate = source->coordinate();
  mesh.triangles.resize(3 * source->below(kMostTriangles + 1));
  const std::size_t vertices = mesh.vertexCount();
  for (std::uint32_t& index : mesh.triangles) {
    const std::uint8_t code = source->byte();
    constexpr std::uint8_t kBeyond = 255;
    const bool is_beyond = code == kBeyond || vertices == 0;
    index = static_cast<std::uint32_t>(is_beyond ? vertices : code % vertices);
  }
  return mesh;
}

RigidTransform poseFrom(ByteSource* source) {
  RigidTransform pose;
  constexpr std::uint8_t kMoved = 100, kTurned = 180, kAny = 230;
  const std::uint8_t kind = source->byte();
  if (kind < kMoved) return pose;
  for (double& t : pose.translation) t = source->coordinate();
  if (kind < kTurned) return pose;
  if (kind < kAny) {  // a quarter turn about z
    const double turned[] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    std::copy(std::begin(turned), std::end(turned), std::begin(pose.rotation));
  } else {
    for (double& r : pose.rotation) r = source->number<double>();
  }
  return pose;
}

// Mostly 0; else as a coordinate, which may be refused.
float marginFrom(ByteSource* source) {
  const bool is_zero = source->below(3) != 0;
  return is_zero ? 0.F : source->coordinate();
}

Options optionsFrom(ByteSource* source) {
  Options options;
  options.adjacent = source->flag() ? AdjacentPairs::kSkip : AdjacentPairs::kBeyondShared;
  options.predicates = source->below(4) < 2 ? Predicates::kExact : Predicates::kConservative;
  options.clusters = static_cast<int>(source->below(40));
  options.iterations = static_cast<int>(source->below(5));
  options.refresh_period = 1 + static_cast<int>(source->below(3));
  options.threads = 1 + static_cast<int>(source->below(2));
  if (source->below(8) == 7) {
    options.fuzzifier = source->number<float>();
    options.overlap = source->coordinate();
    options.clusters = source->number<std::int32_t>();
    options.iterations = source->number<std::int8_t>();
    options.threads = source->number<std::int8_t>() % 4;
  }
  constexpr int kMostClusters = 5000;  // more of them are slow, and no other
  if (options.clusters > kMostClusters && options.clusters <= kMaxClusters) options.clusters = 0;
  return options;
}

// Tries what may be refused; returns whether it was taken.
template <typename Act>
bool isTaken(const Act& act) {
  try {
    act();
    return true;
  } catch (const std::invalid_argument& refusal) {
    requireThat(*refusal.what() != '\0', "a refusal without a reason");
    return false;
  }
}

bool hasBadIndex(const TriangleMesh& mesh) {
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [&mesh](std::uint32_t i) { return i >= mesh.vertexCount(); });
}

void addBodies(ByteSource* source, Scene* scene) {
  const std::size_t count = 1 + source->below(kMostBodies);
  for (std::size_t i = 0; i < count; ++i) {
    const TriangleMesh mesh = meshFrom(source);
    const bool taken = isTaken([&] { scene->addBody("body " + std::to_string(i), mesh); });
    requireThat(taken != hasBadIndex(mesh), "an index out of range was taken, or a good one not");
  }
}

void change(ByteSource* source, Scene* scene) {
  for (BodyId id = 0; id < scene->bodyCount(); ++id) {
    const std::uint8_t what = source->byte();
    constexpr int kMesh = 1, kVertices = 2, kPose = 4, kMargin = 8, kPairs = 16;
    if ((what & kMesh) != 0 && (what & kVertices) != 0) {
      isTaken([&] { scene->setMesh(id, meshFrom(source)); });
    } else if ((what & kVertices) != 0) {
      std::vector<float> vertices = scene->body(id).mesh.vertices;
      for (std::size_t i = source->below(8); i < vertices.size(); i += 7) {
        vertices[i] = source->coordinate();
      }
      scene->setVertices(id, vertices.data(), vertices.size() / 3);
    }
    if ((what & kPose) != 0) isTaken([&] { scene->setPose(id, poseFrom(source)); });
    if ((what & kMargin) != 0) isTaken([&] { scene->setMargin(id, marginFrom(source)); });
    if ((what & kPairs) != 0) {
      const std::uint8_t pairs = source->byte();
      for (BodyId other = 0; other < scene->bodyCount(); ++other) {
        scene->setPairEnabled(id, other, ((pairs >> other) & 1) != 0);
      }
    }
  }
}

// Past the first check: a cycle looked at two triangles or more.
bool tryDetector(const std::uint8_t* data, std::size_t size) {
  ByteSource source(data, size);
  Scene scene;
  addBodies(&source, &scene);
  for (BodyId a = 0; a < scene.bodyCount(); ++a) {
    for (BodyId b = a; b < scene.bodyCount(); ++b) scene.setPairEnabled(a, b, true);
  }
  const auto detector = makeCpuDetector();
  bool looked = false;
  for (int cycle = 0; cycle < kCycles; ++cycle) {
    if (cycle == 0 || source.left() > 0) change(&source, &scene);
    Options options = optionsFrom(&source);
    const std::atomic<bool> stop{source.below(16) == 15};
    options.limits.stop = &stop;
    const bool taken = isTaken([&] {
      const DetectionResult& result = detectChecked(detector.get(), scene, options);
      looked = looked || result.counters.posed >= result.counters.rejected + 2;
    });
    requireThat(taken == problems(options).empty(), "options were refused, or bad ones taken");
    if (cycle > 0 && source.left() == 0) break;
  }
  return looked;
}

const FuzzTargetEntry entry("detector", tryDetector);

}  // namespace
}  // namespace deformable_contact_monitor
