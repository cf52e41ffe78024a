// The backends under test: every TEST_P of the suite runs on each of them.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/detector.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/cuda_error.h"
#include "pair_sets.h"
#include "reference/reference_detectors.h"
#include "test_data.h"

namespace deformable_contact_monitor {

struct Backend {
  const char* name;
  std::unique_ptr<Detector> (*make)();
};

inline std::ostream& operator<<(std::ostream& out, const Backend& backend) {
  return out << backend.name;
}

// Returns a CUDA detector. If $DCM_TEST_PARTITIONS is set, it uses that many devices, which are all
// the first one.
inline std::unique_ptr<Detector> makeCudaOrShares() {
  CudaSettings settings;
  const char* shares = std::getenv("DCM_TEST_PARTITIONS");
  settings.devices.assign(shares == nullptr ? 0 : std::strtoul(shares, nullptr, 10), 0);
  settings.shared_from_triangles = 0;
  return makeCudaDetector(settings);
}

// Returns the backends that users get. CUDA is among them if there is a device.
inline std::vector<Backend> productBackends() {
  std::vector<Backend> backends = {{"cpu", [] { return makeCpuDetector(); }}};
  try {
    makeCudaDetector();
    backends.push_back({"cuda", makeCudaOrShares});
  } catch (const CudaError&) {
    if (isCudaRequired()) throw;
  }
  return backends;
}

// Returns the same and brute force, for small scenes only.
inline std::vector<Backend> allBackends() {
  std::vector<Backend> backends = productBackends();
  backends.push_back({"brute_force", makeBruteForceDetector});
  return backends;
}

class DetectorSuite : public ::testing::TestWithParam<Backend> {
 protected:
  std::vector<TrianglePair> contacts(const Scene& scene, const Options& options = Options()) {
    return detector_->detect(scene, options).contacts;
  }

  std::unique_ptr<Detector> detector_ = GetParam().make();
};

inline std::string backendName(const ::testing::TestParamInfo<Backend>& info) {
  return info.param.name;
}

inline Options withAdjacent(AdjacentPairs adjacent) {
  Options options;
  options.adjacent = adjacent;
  return options;
}

constexpr AdjacentPairs kBothAdjacent[] = {AdjacentPairs::kSkip, AdjacentPairs::kBeyondShared};

}  // namespace deformable_contact_monitor
