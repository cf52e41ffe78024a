#include <mutex>
#include <set>

#include "cuda/cuda_detector.h"
#include "cuda/cycle/single_gpu_detector.cuh"
#include "cuda/device/check.cuh"
#include "cuda/partitions/partitioned_detector.h"

namespace deformable_contact_monitor {
namespace {

// Loads all kernels that a cycle may need, once for each device of the process. CUDA loads a kernel
// when it runs for the first time, which takes longer than a cycle, so a tiny scene runs them here.
void loadKernels(int device) {
  static std::mutex mutex;
  static std::set<int> loaded;
  const std::lock_guard<std::mutex> lock(mutex);
  if (loaded.count(device) > 0) return;
  Scene scene;
  scene.addBody("", {{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.1F}, {0, 1, 2, 1, 3, 2}});
  scene.addBody("", {{0.2F, 0.2F, -1, 0.2F, 0.3F, 1, 0.3F, 0.2F, 1}, {0, 1, 2}});
  scene.setPairEnabled(0, 0, true);
  scene.setPairEnabled(0, 1, true);
  scene.setEarlier(1, RigidTransform());
  Options options;
  options.clusters = 2;
  CudaSettings settings;
  settings.device = device;
  SingleGpuDetector detector(settings);
  for (int i = 0; i < 3; ++i) detector.detect(scene, options);  // the third is a recorded graph
  options.motion = Motion::kSwept;
  detector.detect(scene, options);
  loaded.insert(device);
}

}  // namespace

std::unique_ptr<PartitionDetector> makeCudaPartitionDetector(const CudaSettings& settings) {
  requireUsable(settings.device);
  loadKernels(settings.device);
  return std::make_unique<SingleGpuDetector>(settings);
}

std::unique_ptr<Detector> makeCudaDetector(const CudaSettings& settings) {
  return makePartitionedDetector(settings, makeCudaPartitionDetector);
}

}  // namespace deformable_contact_monitor
