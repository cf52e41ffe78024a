// How much room a cycle has, and how that grows.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cuda/memory/cycle_params.cuh"

namespace deformable_contact_monitor {

// Capacities of the arrays in CycleArrays.
struct CycleSizes {
  // For the scene, as DeviceScene lays it out; those of fans where certificates are asked for.
  std::uint32_t bodies = 0, partners = 0, pair_words = 0;
  std::uint32_t vertices = 0, triangles = 0, vertex_blocks = 0, triangle_blocks = 0;
  std::uint32_t tiles = 0, slots = 0;
  std::uint32_t identity_slots = 0, fan_vertices = 0, fan_places = 0;
  // Of what a cycle finds. Those of candidates and contacts share a memory limit by halves; the
  // others grow by need.
  std::uint32_t clusters = 0, samples = 0;
  std::uint32_t entries = 0, list_words = 0, units = 0, tile_pairs = 0, crowded_pairs = 0;
  std::uint32_t candidates = 0, contacts = 0;
  // In swept motion as those above, otherwise nothing or what was there; and pairs for the host.
  bool swept = false;
  std::uint32_t swept_bodies = 0, swept_vertices = 0, swept_slots = 0;
  std::uint32_t swept_candidates = 0, swept_contacts = 0, open_pairs = 0;

  // Brings the sizes for swept motion up to the others, if `swept`; wherever those have changed.
  void follow();

  // A size to at least `needed`; if it grows beyond what it was once, by half as much again.
  static void raise(std::uint32_t& size, std::uint64_t needed);

  // For another number of clusters, where the rest of the scene stays: a guess.
  void prepareClusters(std::uint32_t count);

  // For so many triangles in so many clusters, and the tiles that there are: a guess. None shrinks
  // but the number of clusters.
  void prepare(std::uint32_t clustered, std::uint32_t cluster_count,
               std::uint64_t memory_limit_bytes);

  // Whether all that a cycle counted has room.
  bool hold(const CycleCounters& counters) const;

  // After a cycle that counted so. True if some capacity grew; candidates and contacts do not
  // beyond the limit. Throws CudaError where the places of members would not fit their bits.
  bool growFor(const CycleCounters& counters, std::uint64_t memory_limit_bytes);

  // After a cycle that fitted: doubles what is nearly full, so that the next ones fit as well; but
  // nothing beyond its limit.
  void growAhead(const CycleCounters& counters, std::uint64_t memory_limit_bytes);
};

}  // namespace deformable_contact_monitor
