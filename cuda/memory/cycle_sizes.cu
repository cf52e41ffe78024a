#include <algorithm>
#include <array>
#include <string>

#include "cuda/device/cuda_error.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/cycle_sizes.cuh"

namespace deformable_contact_monitor {
namespace {

// Return the memory that a candidate or a contact takes, with all arrays that grow with it [bytes].
std::uint64_t candidateBytes(bool swept) {
  const std::uint64_t more = sizeof(SweptState) + 4 * sizeof(std::uint32_t);
  return sizeof(DeviceCandidate) + sizeof(std::uint32_t) + (swept ? more : 0);
}
std::uint64_t contactBytes(bool swept) {
  return 2 * sizeof(std::uint64_t) + 2 * sizeof(Place) +
         (swept ? sizeof(ContactTimes) : sizeof(float));
}

// Returns the wanted number of elements, at most as many as half of the memory limit holds [bytes].
std::uint32_t withinLimit(std::uint64_t wanted, std::uint64_t bytes_each, std::uint64_t limit) {
  constexpr std::uint64_t kMostInAList = std::uint64_t{1} << 30;
  const std::uint64_t most = std::clamp<std::uint64_t>(limit / 2 / bytes_each, 1, kMostInAList);
  return static_cast<std::uint32_t>(std::min(wanted, most));
}

constexpr std::uint64_t kMostPlaces = std::uint64_t{1} << 29;  // places of entries have 29 bits

// A list whose needed length the counters tell, and the greatest length that it may have.
struct List {
  std::uint32_t CycleSizes::*size;
  std::uint64_t needed, most;
};

std::array<List, 8> listsOf(const CycleCounters& c, bool swept, std::uint64_t limit) {
  const auto most = [limit](std::uint64_t bytes) {
    return withinLimit(~std::uint64_t{0}, bytes, limit);
  };
  return {{{&CycleSizes::entries, c.bins_wanted, kMostPlaces},
           {&CycleSizes::list_words, c.list_words, kMostPlaces},
           {&CycleSizes::units, c.units, kMostPlaces},
           {&CycleSizes::tile_pairs, c.tile_pairs, kMostPlaces},
           {&CycleSizes::dense_pairs, c.dense_pairs, kMostPlaces},
           {&CycleSizes::candidates, c.candidates, most(candidateBytes(swept))},
           {&CycleSizes::contacts, c.contacts, most(contactBytes(swept))},
           {&CycleSizes::open_pairs, c.open_pairs, most(sizeof(OpenPair))}}};
}

// Raises `size` to `wanted` or `most`, whichever is less. Returns whether it grew.
bool growTo(std::uint32_t& size, std::uint64_t wanted, std::uint64_t most) {
  wanted = std::min(wanted, most);
  if (wanted <= size) return false;
  size = static_cast<std::uint32_t>(wanted);
  return true;
}

}  // namespace

void CycleSizes::raise(std::uint32_t& size, std::uint64_t needed) {
  if (needed <= size) return;
  const std::uint64_t wanted = size == 0 ? needed : needed + needed / 2;
  size = static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, ~std::uint32_t{0}));
}

void CycleSizes::prepareClusters(std::uint32_t count) {
  constexpr std::uint32_t kLeastSamples = 1024, kSamplesEach = 8;
  clusters = count;
  raise(samples, std::max(kLeastSamples, kSamplesEach * count));
  raise(entries, 4 * std::uint64_t{tiles} + 48 * count + 256);
  raise(units, 4 * std::uint64_t{tiles} + 4 * count + 256);
}

void CycleSizes::prepare(std::uint32_t clustered, std::uint32_t cluster_count,
                         std::uint64_t memory_limit_bytes) {
  prepareClusters(cluster_count);
  // Reserves room for half of all triangles even if most are out of reach now: they may come near
  // in a cycle that has no time to allocate.
  constexpr std::uint32_t kLeastFraction = 2;
  const std::uint64_t n = std::max(clustered, triangles / kLeastFraction);
  raise(list_words, 8 * std::uint64_t{tiles} + 256);
  raise(tile_pairs, 24 * std::uint64_t{tiles} + 256);
  raise(dense_pairs, 4 * std::uint64_t{tiles} + 256);
  const auto within = [&](std::uint32_t& size, std::uint64_t needed, std::uint64_t bytes) {
    std::uint32_t wanted = size;
    raise(wanted, needed);
    size = std::max(size, withinLimit(wanted, bytes, memory_limit_bytes));
  };
  within(candidates, (swept ? 8 : 3) * n + 256, candidateBytes(swept));
  within(contacts, n + n / 4 + 256, contactBytes(swept));
  if (swept) raise(open_pairs, n / 64 + 256);
  follow();
}

void CycleSizes::follow() {
  if (!swept) return;
  swept_bodies = bodies;
  swept_vertices = vertices;
  swept_slots = slots;
  swept_candidates = candidates;
  swept_contacts = contacts;
}

bool CycleSizes::hold(const CycleCounters& c) const {
  return c.bins_wanted <= entries && c.list_words <= list_words && c.units <= units &&
         c.tile_pairs <= tile_pairs && c.dense_pairs <= dense_pairs && c.candidates <= candidates &&
         c.contacts <= contacts && c.open_pairs <= open_pairs;
}

bool CycleSizes::growFor(const CycleCounters& c, std::uint64_t memory_limit_bytes) {
  if (c.bins_wanted >= kMostPlaces || c.list_words >= kMostPlaces || c.units >= kMostPlaces ||
      c.tile_pairs >= kMostPlaces || c.dense_pairs >= kMostPlaces) {
    throw CudaError(
        BackendFault::kSceneTooLarge,
        "the scene is too dense for the CUDA backend: " + std::to_string(c.bins_wanted) +
            " places in clusters, " + std::to_string(c.units) + " work units, " +
            std::to_string(std::uint64_t{c.tile_pairs} + c.dense_pairs) + " pairs of tiles");
  }
  bool grown = false;
  for (const List& list : listsOf(c, swept, memory_limit_bytes)) {
    // Grows beyond the need, so that a scene that changes slowly fits for a while.
    if (list.needed <= this->*list.size) continue;
    grown |= growTo(this->*list.size, list.needed + list.needed / 4 + 256, list.most);
  }
  follow();
  return grown;
}

void CycleSizes::growInAdvance(const CycleCounters& c, std::uint64_t memory_limit_bytes) {
  for (const List& list : listsOf(c, swept, memory_limit_bytes)) {
    const std::uint64_t size = this->*list.size;
    if (list.needed > size - size / 8) growTo(this->*list.size, 2 * list.needed, list.most);
  }
  follow();
}

}  // namespace deformable_contact_monitor
