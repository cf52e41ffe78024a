// Grows the device arrays and sends the settings of a cycle.
#include <algorithm>
#include <cstring>

#include "cuda/cycle/device_cycle.cuh"
#include "cuda/memory/pinned_pages.cuh"

namespace deformable_contact_monitor {

DeviceCycle::DeviceCycle(const CudaSettings& cuda_settings)
    : settings(cuda_settings), device(DeviceTraits::of(cuda_settings.device)) {
  arrays.host_counters.pointTo(counters.data());
  arrays.host_stop.pointTo(stop.word());
  // The multiprocessors share the tests of boxes, while one of them sorts all tiles of a cluster.
  constexpr std::uint32_t kLeast = 4096, kEach = 64;
  arrays.most_brute_force_tiles = std::max(kLeast, kEach * device.multiprocessors);
}

void DeviceCycle::growArrays() {
  if (memory.mustGrow(sizes)) {
    copies.launch();  // the arrays that they write to are about to move
    memory.grow(sizes, stream.get());
  }
  arrays.clusters.count = sizes.clusters;
  arrays.clusters.sample_count = std::min(sizes.samples, scene.triangleCount());
}

void DeviceCycle::addParams() {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): a needless copy does no harm
  if (params_sent_ && std::memcmp(&sent_params_, params.data(), sizeof sent_params_) == 0) return;
  std::memcpy(&sent_params_, params.data(), sizeof sent_params_);
  params_sent_ = true;
  copies.add(static_cast<const CycleParams*>(reachedAt(params.data())), 1,
             arrays.the_params.data());
}

void DeviceCycle::start(const CycleShape& shape) {
  addParams();
  addClearing(arrays, shape, copies);
  copies.launch();
}

CycleShape DeviceCycle::shapeOf(const Options& options, int refinements) const {
  CycleShape shape;
  shape.device = device;
  shape.identify = scene.searchesEqualVertices(options);
  shape.refinements = refinements;
  shape.swept = options.motion == Motion::kSwept;
  shape.adjacent = scene.anySelf() && options.adjacent == AdjacentPairs::kBeyondShared;
  shape.pads = shape.swept && scene.anyLengths().pads;
  shape.times = shape.swept && options.first_times;
  shape.fans = params[0].fans != 0;
  shape.leaves_few = params[0].leaves_few != 0;
  shape.margins = params[0].margins != 0;
  shape.nearest = arrays.nearest.pair_count > 0;
  return shape;
}

}  // namespace deformable_contact_monitor
