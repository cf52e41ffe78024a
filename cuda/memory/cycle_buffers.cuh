// The device's arrays for clusters, members, candidates and contacts.
#pragma once

#include <cstdint>

#include "cuda/memory/cycle_sizes.cuh"
#include "cuda/memory/cycle_view.cuh"
#include "cuda/memory/device_buffer.cuh"

namespace deformable_contact_monitor {

class CycleBuffers {
 public:
  // Makes room; what is in an array that grows is lost. True if some array moved.
  bool grow(const CycleSizes& sizes);
  void view(CycleView& cycle);
  std::uint64_t bytes() const;

 private:
  DeviceBuffer<CycleCounters> counters_;
  DeviceBuffer<CycleParams> params_;
  DeviceBuffer<Vec3f> prototypes_, live_prototypes_;
  DeviceBuffer<float> list_reach_;
  DeviceBuffer<Neighbour> neighbours_;
  DeviceBuffer<std::uint32_t> neighbour_cluster_;
  DeviceBuffer<float4> membership_sums_;
  DeviceBuffer<Sample> samples_;
  DeviceBuffer<Bin> bins_, next_bins_;
  DeviceBuffer<std::uint32_t> member_count_;
  DeviceBuffer<Member> members_;
  DeviceBuffer<uint2> wide_;
  DeviceBuffer<std::uint32_t> lists_;
  DeviceBuffer<ClusterFrame> frames_;
  DeviceBuffer<Moments> moments_;
  DeviceBuffer<PackedBox> sweep_boxes_;
  DeviceBuffer<std::uint32_t> sweep_keys_;
  DeviceBuffer<uint4> world_boxes_, sweep_ids_;
  DeviceBuffer<std::uint32_t> bucket_begin_;
  DeviceBuffer<WorkUnit> units_;
  DeviceBuffer<Candidate> candidates_;
  DeviceBuffer<std::uint32_t> open_;
  DeviceBuffer<std::uint64_t> contacts_;
  DeviceBuffer<float> separations_m_;
  PinnedBuffer<CycleCounters> host_counters_;
};

}  // namespace deformable_contact_monitor
