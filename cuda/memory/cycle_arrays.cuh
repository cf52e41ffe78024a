// Collects the arrays of all stages: everything that the kernels of a cycle read and write. Kernels
// get a copy of this struct, which is valid until the memory grows.
#pragma once

#include "cuda/memory/contact_arrays.cuh"
#include "cuda/memory/scene_arrays.cuh"
#include "cuda/memory/sweep_arrays.cuh"
#include "cuda/memory/tile_arrays.cuh"

namespace deformable_contact_monitor {

struct CycleArrays : ArrayGroup {
  explicit CycleArrays(DeviceMemory& memory)
      : ArrayGroup(memory),
        scene(memory),
        clusters(memory),
        tiles(memory),
        sweep(memory),
        contacts(memory) {}

  SceneArrays scene;
  ClusterArrays clusters;
  TileArrays tiles;
  SweepArrays sweep;
  ContactArrays contacts;

  PinnedPointer<CycleCounters> host_counters;  // to which the last kernel copies the counters
  PinnedPointer<std::uint32_t> host_stop;      // not 0: the cycle is to end early

  __device__ const CycleParams& params() const { return *the_params.data(); }
  __device__ CycleCounters& counters() const { return *the_counters.data(); }
  // Returns whether there is only one cluster, of few tiles. Then no cluster structures are built,
  // and the box of each tile is tested against that of every other tile.
  __host__ __device__ bool usesBruteForce() const {
    constexpr std::uint32_t kMostTiles = 4096;
    return clusters.count == 1 && scene.tile_count <= kMostTiles;
  }
  // Returns how many contacts are on the list; others were found but had no room.
  __device__ std::uint32_t listedContacts() const {
    return static_cast<std::uint32_t>(
        min(counters().contacts, static_cast<unsigned long long>(contacts.contacts.size())));
  }

  DeviceArray<CycleParams, Place> the_params{*this, 1U};
  DeviceArray<CycleCounters, Place> the_counters{*this, 1U};
};

}  // namespace deformable_contact_monitor
