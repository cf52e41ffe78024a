// The clusters on the device (stage cluster): prototypes and what finds the nearest of them.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/rules/half_space.h"
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// A centroid for fuzzy c-means [scaled], and a prototype near it, or kNone: no sample.
struct Sample {
  Vec3f centroid;
  ClusterIndex near;
};

struct ClusterArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  std::uint32_t count = 0;         // of clusters
  std::uint32_t sample_count = 0;  // of samples

  DeviceArray<Vec3f, ClusterIndex> prototypes{*this, &CycleSizes::clusters};  // [scaled]
  // The same [scaled]; but those that coincide with an earlier one are far off.
  DeviceArray<Vec3f, ClusterIndex> live_prototypes{*this, &CycleSizes::clusters};
  // As in PrototypesView.
  DeviceArray<float, ClusterIndex> list_reach{*this, &CycleSizes::clusters};
  DeviceArray<Neighbour, ClusterIndex, kMostNeighbours> neighbours{*this, &CycleSizes::clusters};
  DeviceArray<std::uint32_t, ClusterIndex, kMostNeighbours> neighbour_cluster{
      *this, &CycleSizes::clusters};
  // sum u^m (x - p), sum u^m.
  DeviceArray<float4, ClusterIndex> membership_sums{*this, &CycleSizes::clusters};
  DeviceArray<Sample, Place> samples{*this, &CycleSizes::samples};

  __device__ PrototypesView view() const {
    return {live_prototypes.data(), list_reach.data(), neighbours.data(), neighbour_cluster.data(),
            count};
  }
};

}  // namespace deformable_contact_monitor
