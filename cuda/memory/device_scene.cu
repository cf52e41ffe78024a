// Keeps the scene on the device. "Laying out" numbers the bodies, vertices, triangles and tiles; it
// is repeated only if bodies, topologies or enabled pairs change. Vertices and poses are sent when
// they change.
#include <algorithm>
#include <cstring>

#include "core/common/parallel.h"
#include "core/common/scene_queries.h"
#include "core/rules/margins.h"
#include "cuda/memory/device_scene.cuh"
#include "cuda/memory/host_copy.cuh"
#include "cuda/memory/pinned_pages.cuh"
#include "cuda/stages/tiles.cuh"

namespace deformable_contact_monitor {
namespace {

// Adds a copy from page-locked memory, which must stay until the stream has been waited for.
template <class T>
void add(const T* from, std::size_t count, T* to, HostCopies& copies) {
  if (count > 0) copies.add(static_cast<const T*>(reachedAt(from)), count, to);
}

template <class T>
void add(const SceneTables::List<T>& from, T* to, HostCopies& copies) {
  add(from.data(), from.size(), to, copies);
}

// Returns the device's address of a body's vertices or triangles. If these are not in page-locked
// memory, they are copied to `staged` first, at number `first` of `all` numbers.
template <class List, class T>
const T* reached(const List& numbers, std::size_t first, std::size_t all, PinnedBuffer<T>& staged) {
  const void* from = reachedAt(numbers.data());
  if (from == nullptr) {
    constexpr std::size_t kPiece = std::size_t{1} << 14;
    staged.grow(all);  // for all bodies at once: growing frees memory that copies may still read
    T* const its = staged.data() + first;
    parallelBlocks(numbers.size(), kPiece, [&](std::size_t, std::size_t begin, std::size_t end) {
      std::copy_n(numbers.data() + begin, end - begin, its + begin);
    });
    from = reachedAt(its);
  }
  return static_cast<const T*>(from);
}

template <class List>
void add(const List& vertices, std::size_t first, std::size_t all, PinnedBuffer<float>& staged,
         float* to, HostCopies& copies) {
  copies.add(reached(vertices, first, all, staged), vertices.size(), to + first);
}

// Returns the size of the table of equal vertices, a power of two. Searches are short if it is
// nearly empty; but a large one does not fit the device's cache, and must be cleared in each cycle.
std::uint32_t identitySlots(std::uint32_t vertices) {
  constexpr std::uint32_t kMany = std::uint32_t{1} << 19;
  const std::uint64_t least = std::uint64_t{vertices} * (vertices < kMany ? 4 : 2);
  std::uint32_t slots = 16;
  while (slots < least) slots *= 2;
  return slots;
}

}  // namespace

std::vector<DeviceScene::LaidOutBody> DeviceScene::bodiesOf(const Scene& scene) const {
  std::vector<LaidOutBody> bodies;
  bodies.reserve(tables_.taking_part.size());
  for (const BodyId id : tables_.taking_part) {
    const Body& body = scene.body(id);
    bodies.push_back(
        {id, body.topology_revision, static_cast<std::uint32_t>(body.mesh.triangleCount())});
  }
  return bodies;
}

// Returns whether the layout fits this scene. Pairs that were disabled and enabled again do not
// need another layout.
bool DeviceScene::isLaidOut(const Scene& scene) const {
  if (!laid_out_) return false;
  if (pairs_revision_ != scene.pairsRevision() &&
      (pairs_ != scene.enabledPairs() || disabled_parts_ != scene.disabledParts())) {
    return false;
  }
  return laid_out_bodies_ == bodiesOf(scene) && hasPartsOf(scene);
}

// Returns whether the layout has the parts of this scene.
bool DeviceScene::hasPartsOf(const Scene& scene) const {
  return std::equal(
      parts_.begin(), parts_.end(), scene.bodies().begin(), scene.bodies().end(),
      [](std::uint64_t sent, const Body& body) { return sent == body.parts_revision; });
}

DeviceScene::Change DeviceScene::layOut(const Scene& scene, Motion motion, bool fans) {
  sizes_.swept = motion == Motion::kSwept;
  Change change;
  if (!isLaidOut(scene)) change = layOutAnew(scene);
  pairs_revision_ = scene.pairsRevision();
  if (fans && tables_.any_self_mesh && !has_fans_) sizeFans(scene);
  sizes_.follow();
  any_from_device_ =
      std::any_of(tables_.taking_part.begin(), tables_.taking_part.end(),
                  [&](BodyId id) { return scene.body(id).device_vertices.has_value(); });
  return change;
}

// Compares two layouts, both in the order of the bodies.
DeviceScene::Change DeviceScene::changeOf(const std::vector<LaidOutBody>& before,
                                          const std::vector<LaidOutBody>& now) {
  Change change{true};
  auto old = before.begin();
  for (const LaidOutBody& body : now) {
    for (; old != before.end() && old->id < body.id; ++old)
      change.fewer_triangles += old->triangles;
    std::uint32_t had = 0;
    if (old != before.end() && old->id == body.id) {
      had = old->triangles;
      if (!(*old == body)) change.replaced_triangles += std::min(had, body.triangles);
      ++old;
    }
    change.more_triangles += body.triangles > had ? body.triangles - had : 0;
    change.fewer_triangles += had > body.triangles ? had - body.triangles : 0;
  }
  for (; old != before.end(); ++old) change.fewer_triangles += old->triangles;
  return change;
}

DeviceScene::Change DeviceScene::layOutAnew(const Scene& scene) {
  const std::vector<LaidOutBody> before = laid_out_ ? laid_out_bodies_ : std::vector<LaidOutBody>();
  laid_out_ = has_fans_ = bodies_sent_ = false;  // until the new layout is complete
  repeated_vertices_ = kNotCounted;
  sharing_pairs_ = 0;
  pairs_ = scene.enabledPairs();
  disabled_parts_ = scene.disabledParts();
  parts_.clear();
  for (const Body& body : scene.bodies()) parts_.push_back(body.parts_revision);
  tables_ = SceneTables(scene);
  laid_out_bodies_ = bodiesOf(scene);
  const auto same =
      std::mismatch(laid_out_bodies_.begin(), laid_out_bodies_.end(), before.begin(), before.end());
  const auto first = static_cast<std::uint32_t>(same.first - laid_out_bodies_.begin());
  tiled_ = std::min(tiled_, first);
  arrays_.body_count = static_cast<std::uint32_t>(tables_.bodies.size());
  arrays_.pair_row = tables_.pair_row;
  arrays_.triangle_count = tables_.triangle_count;
  arrays_.tile_count = tables_.tile_count;
  CycleSizes::raise(sizes_.bodies, tables_.bodies.size());
  CycleSizes::raise(sizes_.partners, tables_.partners.size());
  CycleSizes::raise(sizes_.pair_words, tables_.pair_enabled.size());
  CycleSizes::raise(sizes_.parts, tables_.parts.size());
  CycleSizes::raise(sizes_.part_triangles, tables_.part.size());
  CycleSizes::raise(sizes_.vertices, tables_.vertex_count);
  CycleSizes::raise(sizes_.triangles, tables_.triangle_count);
  CycleSizes::raise(sizes_.vertex_blocks, tables_.vertex_blocks.size());
  CycleSizes::raise(sizes_.triangle_blocks, tables_.triangle_blocks.size());
  CycleSizes::raise(sizes_.tiles, tables_.tile_count);
  sizes_.slots = kWarp * sizes_.tiles;
  sizes_.identity_slots = identitySlots(tables_.any_self ? tables_.vertex_count : 0);
  vertices_.resize(scene.bodyCount());
  earlier_.resize(scene.bodyCount());
  for (std::uint32_t i = first; i < tables_.taking_part.size(); ++i) {
    vertices_[tables_.taking_part[i]] = earlier_[tables_.taking_part[i]] = 0;  // no revision is 0
  }
  first_new_ = first;
  return changeOf(before, laid_out_bodies_);
}

// Adds copies of the triangles' vertex numbers, for the bodies from first_new_ on. Earlier bodies
// have them on the device already.
void DeviceScene::addCorners(const Scene& scene, HostCopies& copies) {
  for (std::uint32_t i = first_new_; i < tables_.taking_part.size(); ++i) {
    const HostList<std::uint32_t>& local = scene.body(tables_.taking_part[i]).mesh.triangles;
    const std::size_t first = 3 * std::size_t{tables_.bodies[i].first_triangle};
    copies.addNumbers(reached(local, first, 3 * std::size_t{sizes_.triangles}, staged_corners_),
                      local.size(), arrays_.corners.data() + first, tables_.bodies[i].first_vertex);
  }
}

void DeviceScene::sendLayout(const Scene& scene, cudaStream_t stream) {
  growArrays(stream);
  if (laid_out_) return;
  arrays_.vertex_block_count = static_cast<std::uint32_t>(tables_.vertex_blocks.size());
  arrays_.triangle_block_count = static_cast<std::uint32_t>(tables_.triangle_blocks.size());
  arrays_.identity_mask = arrays_.identity_table.size() - 1;
  HostCopies copies(stream);
  addCorners(scene, copies);
  add(tables_.partners, arrays_.partners.data(), copies);
  add(tables_.group_mask, arrays_.group_mask.data(), copies);
  add(tables_.pair_enabled, arrays_.pair_enabled.data(), copies);
  add(tables_.part, arrays_.part.data(), copies);
  add(tables_.listed, arrays_.listed_bodies.data(), copies);
  add(tables_.vertex_blocks, arrays_.vertex_blocks.data(), copies);
  add(tables_.triangle_blocks, arrays_.triangle_blocks.data(), copies);
  copies.launch();
  laid_out_ = true;
}

// Grows the arrays, and the page-locked buffers through which bodies are sent.
void DeviceScene::growArrays(cudaStream_t stream) {
  memory_.grow(sizes_, stream);
  staged_bodies_.grow(sizes_.bodies);
  if (sizes_.swept) staged_earlier_bodies_.grow(sizes_.bodies);
}

bool DeviceScene::searchesEqualVertices(const Options& options) const {
  if (!tables_.any_self) return false;
  if (options.motion == Motion::kSwept) return true;
  if (options.adjacent != AdjacentPairs::kSkip && tables_.any_self_mesh) return true;
  constexpr std::uint32_t kFewOf = 8;
  return repeated_vertices_ > tables_.self_vertices / kFewOf ||
         sharing_pairs_ > tables_.self_vertices;
}

void DeviceScene::makeTiles(cudaStream_t stream) {
  if (tiled_ >= tables_.bodies.size()) return;
  const DeviceBody& first = tables_.bodies[tiled_];
  UntiledBodies bodies{BodyIndex(tiled_), first.first_triangle, first.first_tile, 0};
  for (std::size_t i = tiled_; i < tables_.bodies.size(); ++i) {
    bodies.most_triangles = std::max(bodies.most_triangles, tables_.bodies[i].triangle_count);
  }
  launchTiles(arrays_, bodies, scratch_, stream);
  if (tiled_ == 0) deformed_ = 0;
  tiled_ = arrays_.body_count;
}

void DeviceScene::makeTilesAgain(cudaStream_t stream) {
  if (deformed_ < kCyclesOfTiles) return;
  tiled_ = 0;
  makeTiles(stream);
}

// Sets the sizes of the vertex rings. Vertices of bodies without contacts with themselves have no
// ring.
void DeviceScene::sizeFans(const Scene& scene) {
  std::uint64_t places = 0;
  for (std::uint32_t i = 0; i < tables_.taking_part.size(); ++i) {
    if (tables_.bodies[i].has_self == 0) continue;
    const TriangleMesh& mesh = scene.body(tables_.taking_part[i]).mesh;
    places += mesh.vertexCount() + mesh.triangles.size();
  }
  CycleSizes::raise(sizes_.fan_vertices, std::uint64_t{tables_.vertex_count} + 1);
  CycleSizes::raise(sizes_.fan_places, places);
}

void DeviceScene::findFans(cudaStream_t stream) {
  if (has_fans_) return;
  launchFanRings(arrays_, tables_.vertex_count, scratch_, stream);
  has_fans_ = true;
}

void DeviceScene::forgetSent() {
  std::fill(vertices_.begin(), vertices_.end(), 0);  // no revision is 0
  std::fill(earlier_.begin(), earlier_.end(), 0);
  bodies_sent_ = false;
}

void DeviceScene::sendVertices(const Scene& scene, Motion motion, HostCopies& copies,
                               cudaStream_t stream) {
  for (const BodyId id : tables_.taking_part) {
    const Body& from = scene.body(id);
    if (!from.device_vertices) continue;
    if (vertices_[id] != from.vertices_revision) {
      DeviceVerticesReader::requireReadable(from, device_);
    }
  }
  bool any = false;
  for (std::uint32_t i = 0; i < tables_.taking_part.size(); ++i) {
    const BodyId id = tables_.taking_part[i];
    const Body& from = scene.body(id);
    if (vertices_[id] == from.vertices_revision) continue;
    any = true;
    const std::size_t first = 3 * std::size_t{tables_.bodies[i].first_vertex};
    if (from.device_vertices) {
      device_vertices_.copy(from, arrays_.received.data() + first, stream);
    } else {
      add(from.mesh.vertices, first, 3 * std::size_t{sizes_.vertices}, staged_vertices_,
          arrays_.received.data(), copies);
    }
  }
  for (const BodyId id : tables_.taking_part) vertices_[id] = scene.body(id).vertices_revision;
  deformed_ += any ? 1 : 0;
  if (motion == Motion::kSwept) sendEarlierVertices(scene, copies);
}

void DeviceScene::sendEarlierVertices(const Scene& scene, HostCopies& copies) {
  const auto differs = [&](BodyId id) {
    const Body& from = scene.body(id);
    const bool any = from.earlier && !from.earlier->vertices.empty();
    return any && earlier_[id] != from.earlier_revision;
  };
  for (std::uint32_t i = 0; i < tables_.taking_part.size(); ++i) {
    const BodyId id = tables_.taking_part[i];
    if (!differs(id)) continue;
    const std::size_t first = 3 * std::size_t{tables_.bodies[i].first_vertex};
    add(scene.body(id).earlier->vertices, first, 3 * std::size_t{sizes_.vertices},
        staged_earlier_vertices_, arrays_.earlier_received.data(), copies);
  }
  for (const BodyId id : tables_.taking_part) {
    if (differs(id)) earlier_[id] = scene.body(id).earlier_revision;
  }
}

Scene DeviceScene::onHost(const Scene& scene, cudaStream_t stream) const {
  Scene on_host = scene;
  std::vector<float> xyz;
  for (std::uint32_t i = 0; i < tables_.taking_part.size(); ++i) {
    const BodyId id = tables_.taking_part[i];
    if (!scene.body(id).device_vertices) continue;
    const std::size_t count = tables_.bodies[i].vertex_count;
    xyz.resize(3 * count);
    checkCuda(
        cudaMemcpyAsync(xyz.data(),
                        arrays_.received.data() + 3 * std::size_t{tables_.bodies[i].first_vertex},
                        xyz.size() * sizeof(float), cudaMemcpyDeviceToHost, stream),
        "cudaMemcpyAsync to the host");
    checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
    on_host.setVertices(id, xyz.data(), count);
  }
  return on_host;
}

void DeviceScene::listRejectedParts(const Scene& scene, DetectionResult& result,
                                    cudaStream_t stream) const {
  if (tables_.parts.empty() || result.counters.rejected == 0) return;
  std::vector<std::uint32_t> counts(tables_.parts.size());
  checkCuda(cudaMemcpyAsync(counts.data(), arrays_.rejected.data(),
                            counts.size() * sizeof(std::uint32_t), cudaMemcpyDeviceToHost, stream),
            "cudaMemcpyAsync to the host");
  checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto& [id, part] = tables_.parts[i];
    if (counts[i] > 0 && !scene.body(id).parts.empty()) {
      result.rejected_parts.push_back({id, part, counts[i]});
    }
  }
}

void DeviceScene::sendBodies(const Scene& scene, const Options& options, const SceneScale& scale,
                             HostCopies& copies) {
  const bool swept = options.motion == Motion::kSwept;
  any_ = {listsNearPairs(scene, options), scene.anyPad()};
  for (std::uint32_t i = 0; i < tables_.taking_part.size(); ++i) {
    const Body& from = scene.body(tables_.taking_part[i]);
    DeviceBody& body = tables_.bodies[i];
    body.pose = from.pose;
    body.identity_pose = from.pose.isIdentity() ? 1 : 0;
    body.margin_m = swept ? grownPad(from.pad_m) : listedMargin(from, options);
    body.slack = scaledSlack(body.margin_m, scale);
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): a needless copy does no harm
    bodies_sent_ = bodies_sent_ && std::memcmp(&staged_bodies_[i], &body, sizeof body) == 0;
    staged_bodies_[i] = body;
  }
  if (!bodies_sent_) {
    add(staged_bodies_.data(), tables_.bodies.size(), arrays_.bodies.data(), copies);
  }
  if (swept) addEarlierBodies(scene, copies);
  bodies_sent_ = true;
}

void DeviceScene::addEarlierBodies(const Scene& scene, HostCopies& copies) {
  for (std::uint32_t i = 0; i < tables_.taking_part.size(); ++i) {
    const Body& from = scene.body(tables_.taking_part[i]);
    EarlierBody& body = staged_earlier_bodies_[i];
    body.pose = from.earlier ? from.earlier->pose : from.pose;
    body.identity_pose = body.pose.isIdentity() ? 1 : 0;
    body.is_still = from.earlier ? 0 : 1;
    body.has_vertices = from.earlier && !from.earlier->vertices.empty() ? 1 : 0;
    body.pad_m = from.pad_m;
  }
  add(staged_earlier_bodies_.data(), tables_.bodies.size(), arrays_.earlier_bodies.data(), copies);
}

}  // namespace deformable_contact_monitor
