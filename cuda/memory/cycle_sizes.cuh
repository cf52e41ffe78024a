// Keeps the sizes of the device arrays, and decides how they grow.
#pragma once

#include <cstdint>

#include "cuda/memory/cycle_params.cuh"

namespace deformable_contact_monitor {

// The capacities of the arrays in CycleArrays, in elements.
struct CycleSizes {
  // Sizes of the scene, which DeviceScene sets. Those of fans are set only if certified fans are
  // needed.
  std::uint32_t bodies = 0, partners = 0, pair_words = 0;
  std::uint32_t parts = 0, part_triangles = 0, part_tiles = 0;  // only if some body has parts
  std::uint32_t vertices = 0, triangles = 0, vertex_blocks = 0, triangle_blocks = 0;
  std::uint32_t tiles = 0, slots = 0;
  std::uint32_t identity_slots = 0, fan_vertices = 0, fan_places = 0;
  // Sizes of the search for nearest pairs, which DeviceNearest sets where it is asked for.
  std::uint32_t nearest_pairs = 0, regions = 0, nearest_tiles = 0, near_tiles = 0, nearest_hits = 0;
  // Sizes of what a cycle finds. Candidates and contacts may use half of the memory limit each; the
  // others grow as needed.
  std::uint32_t clusters = 0, samples = 0;
  std::uint32_t entries = 0, list_words = 0, units = 0, tile_pairs = 0, dense_pairs = 0;
  std::uint32_t candidates = 0, contacts = 0;
  // Sizes for swept motion. They are equal to those above in swept motion, and stay as they are
  // otherwise. The last one is the room for pairs that are left to the host.
  bool swept = false;
  std::uint32_t swept_bodies = 0, swept_vertices = 0, swept_slots = 0;
  std::uint32_t swept_candidates = 0, swept_contacts = 0, open_pairs = 0;

  // Sets the sizes for swept motion to the others, if `swept`. Call it after each change of those.
  void follow();

  // Raises a size to at least `needed`. A size that was set before grows by half as much again.
  static void raise(std::uint32_t& size, std::uint64_t needed);

  // Estimates the sizes for another number of clusters in the same scene.
  void prepareClusters(std::uint32_t count);

  // Estimates the sizes for `clustered` triangles in `cluster_count` clusters, and the scene's
  // tiles. No size shrinks, except the number of clusters.
  void prepare(std::uint32_t clustered, std::uint32_t cluster_count,
               std::uint64_t memory_limit_bytes);

  // Returns whether all that a cycle counted has room.
  bool hold(const CycleCounters& counters) const;

  // Grows the sizes after a cycle with these counters. Returns whether some size grew; candidates
  // and contacts stay within the limit. Throws CudaError if a list would need more places than its
  // indices can address.
  bool growFor(const CycleCounters& counters, std::uint64_t memory_limit_bytes);

  // Doubles sizes that are nearly full after a cycle that fitted, so that the next cycles fit as
  // well. Sizes stay within the limit.
  void growInAdvance(const CycleCounters& counters, std::uint64_t memory_limit_bytes);
};

}  // namespace deformable_contact_monitor
