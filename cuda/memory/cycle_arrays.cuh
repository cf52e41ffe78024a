// All that the kernels of a cycle see: the arrays of each stage. Kernels get a copy, which is of
// use until the memory grows.
#pragma once

#include "cuda/memory/cluster_arrays.cuh"
#include "cuda/memory/contact_arrays.cuh"
#include "cuda/memory/member_arrays.cuh"
#include "cuda/memory/scene_arrays.cuh"
#include "cuda/memory/sweep_arrays.cuh"

namespace deformable_contact_monitor {

struct CycleArrays : ArrayGroup {
  explicit CycleArrays(DeviceMemory& memory)
      : ArrayGroup(memory),
        scene(memory),
        clusters(memory),
        members(memory),
        sweep(memory),
        contacts(memory) {}

  SceneArrays scene;
  ClusterArrays clusters;
  MemberArrays members;
  SweepArrays sweep;
  ContactArrays contacts;

  PinnedPointer<CycleCounters> host_counters;  // where the last kernel leaves the counters
  PinnedPointer<std::uint32_t> host_stop;      // not 0: the cycle is to end

  __device__ const CycleParams& params() const { return *the_params.data(); }
  __device__ CycleCounters& counters() const { return *the_counters.data(); }
  // One cluster of few tiles: then nothing is made of clusters, for each tile is looked at with
  // each other.
  __host__ __device__ bool together() const {
    constexpr std::uint32_t kMostTiles = 4096;
    return clusters.count == 1 && scene.tile_count <= kMostTiles;
  }
  // How many of the contacts found have a place on the list.
  __device__ std::uint32_t listedContacts() const {
    return static_cast<std::uint32_t>(
        min(counters().contacts, static_cast<unsigned long long>(contacts.contacts.size())));
  }

  DeviceArray<CycleParams, Place> the_params{*this, 1U};
  DeviceArray<CycleCounters, Place> the_counters{*this, 1U};
};

}  // namespace deformable_contact_monitor
