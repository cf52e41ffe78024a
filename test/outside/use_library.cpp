// Uses all of the library that is public. Ends with 0 if it does what its headers say; prints the
// contacts.
#include <deformable_contact_monitor/core/backend_choice.h>
#include <deformable_contact_monitor/core/backend_error.h>
#include <deformable_contact_monitor/core/cpu_detector.h>
#include <deformable_contact_monitor/core/detector_pool.h>
#include <deformable_contact_monitor/core/mesh_file.h>
#include <deformable_contact_monitor/core/options.h>
#include <deformable_contact_monitor/core/scene.h>
#include <deformable_contact_monitor/cuda/detector_choice.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace dcm = deformable_contact_monitor;

namespace {

int g_failures = 0;

void expect(bool ok, const std::string& what) {
  if (ok) return;
  ++g_failures;
  std::cerr << "not so: " << what << "\n";
}

template <class Error>
std::string refusalOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "(no refusal)";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// Two parallel triangles in "plate", at x = 0 and x = 1; a needle that goes through the second one
// and ends on the first.
dcm::Scene plateAndNeedle() {
  dcm::TriangleMesh plate;
  plate.vertices = {0, -1, -1, 0, 1, -1, 0, 0, 1, 1, -1, -1, 1, 1, -1, 1, 0, 1};
  plate.triangles = {0, 1, 2, 3, 4, 5};
  dcm::TriangleMesh needle;
  needle.vertices = {0, 0, 0, 2, 0, 0, 2, 0.25F, 0};
  needle.triangles = {0, 1, 2};
  dcm::Scene scene;
  const dcm::BodyId a = scene.addBody("plate", plate);
  const dcm::BodyId b = scene.addBody("needle", needle);
  scene.setPairEnabled(a, b, true);
  return scene;
}

const std::vector<dcm::TrianglePair>& known() {
  static const std::vector<dcm::TrianglePair> pairs = {{0, 0, 1, 0}, {0, 1, 1, 0}};
  return pairs;
}

void checkDetector(dcm::Detector* detector) {
  dcm::Scene scene = plateAndNeedle();
  dcm::Options options;
  options.threads = 1;
  options.limits.deadline = std::chrono::steady_clock::now() + dcm::fromSeconds(60);
  const dcm::DetectionResult& result = detector->detect(scene, options);
  const std::string backend = detector->backend();
  expect(result.contacts == known(), "known pairs, " + backend);
  expect(result.guaranteed && !result.cut_off, "a whole, guaranteed result, " + backend);

  // 0.5 m off, and the needle touches nothing; within a margin it is near both plates.
  dcm::RigidTransform away;
  away.translation[2] = 1.5;
  scene.setPose(1, away);
  expect(detector->detect(scene).contacts.empty(), "apart, " + backend);
  scene.setMargin(1, 1);
  expect(detector->detect(scene).separations_m.size() == 2, "separations, " + backend);
}

void checkRefusals() {
  dcm::Scene scene = plateAndNeedle();
  const auto detector = dcm::makeCpuDetector();
  dcm::Options options;
  options.overlap = 2;
  expect(contains(refusalOf<std::invalid_argument>([&] { detector->detect(scene, options); }),
                  "overlap is 2"),
         "options out of range are refused");
  expect(contains(refusalOf<std::invalid_argument>([&] { scene.setVertices(1, nullptr, 2); }),
                  "needle: 2 vertices"),
         "too few vertices are refused");
  expect(contains(refusalOf<std::runtime_error>([] { dcm::readMeshFile("no/such.obj"); }),
                  "no/such.obj"),
         "a missing file is named");
  const float somewhere = 0;
  scene.setDeviceVertices(1, &somewhere, 3);
  expect(contains(refusalOf<std::invalid_argument>([&] { detector->detect(scene); }),
                  "needle: its vertices are on a device, which backend \"cpu\" cannot read"),
         "device vertices are refused by name");
}

// CUDA, or a BackendError that says why not; the choice falls back.
void checkChoice() {
  checkDetector(dcm::makeDetector().get());
  checkDetector(dcm::makeDetector(dcm::BackendChoice::kCpu).get());
  std::string why;
  const auto fallen =
      dcm::makeDetector(dcm::BackendChoice::kCuda, dcm::WithoutCuda::kFallBack, dcm::CudaSettings(),
                        [&why](const dcm::BackendState& state) { why = state.problem; });
  checkDetector(fallen.get());
  if (why.empty()) return;
  expect(fallen->backend() == "cpu", "the CPU takes over");
  expect(
      refusalOf<dcm::BackendError>([] { dcm::makeDetector(dcm::toBackendChoice("cuda")); }) == why,
      "cuda by name is refused with the same reason");
  std::cerr << "without CUDA: " << why << "\n";
}

void checkMeshFile() {
  const std::string path = "use_library.off";
  std::ofstream(path) << "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const dcm::TriangleMesh mesh = dcm::readMeshFile(path);
  std::remove(path.c_str());
  expect(dcm::isMeshFileName(path) && mesh.triangleCount() == 1, "an OFF file is read");
}

}  // namespace

int main() {
  checkDetector(dcm::makeCpuDetector().get());
  checkRefusals();
  checkChoice();
  checkMeshFile();
  const dcm::Scene scene = plateAndNeedle();
  const auto detector = dcm::makeDetector();
  for (const dcm::TrianglePair& pair : detector->detect(scene).contacts) {
    std::cout << pair.body_a << " " << pair.triangle_a << " " << pair.body_b << " "
              << pair.triangle_b << "\n";
  }
  return g_failures == 0 ? 0 : 1;
}
