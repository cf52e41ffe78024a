#include <algorithm>
#include <string>

#include "core/rules/sampling.h"
#include "cuda/device/cuda_error.h"
#include "cuda/memory/contact_arrays.cuh"
#include "cuda/memory/cycle_sizes.cuh"

namespace deformable_contact_monitor {
namespace {

// What a candidate and a contact take, with the arrays that go with them [bytes].
std::uint64_t candidateBytes(bool swept) {
  const std::uint64_t more = sizeof(SweptState) + 4 * sizeof(std::uint32_t);
  return sizeof(DeviceCandidate) + sizeof(std::uint32_t) + (swept ? more : 0);
}
std::uint64_t contactBytes(bool swept) {
  return 2 * sizeof(std::uint64_t) + sizeof(Place) + (swept ? sizeof(ContactTimes) : sizeof(float));
}

std::uint32_t withinLimit(std::uint64_t wanted, std::uint64_t bytes_each, std::uint64_t limit) {
  constexpr std::uint64_t kMostPlaces = std::uint64_t{1} << 30;
  const std::uint64_t most = std::clamp<std::uint64_t>(limit / 2 / bytes_each, 1, kMostPlaces);
  return static_cast<std::uint32_t>(std::min(wanted, most));
}

// A little more than is needed, so that a scene that changes fits for a while.
bool grow(std::uint32_t& size, std::uint64_t needed, std::uint64_t most) {
  const std::uint64_t wanted = std::min(needed + needed / 4 + 256, most);
  if (needed <= size || wanted <= size) return false;
  size = static_cast<std::uint32_t>(wanted);
  return true;
}

}  // namespace

void CycleSizes::prepare(std::uint32_t clustered, std::uint32_t cluster_count,
                         std::uint64_t memory_limit_bytes) {
  constexpr std::uint32_t kLeastSamples = 1024;
  clusters = cluster_count;
  samples = samplingOf(triangles, cluster_count, kLeastSamples).samples;
  members = std::max(members, clustered * 2 + 48 * cluster_count + 256);
  list_words = std::max(list_words, clustered + 256);
  units = std::max(units, clustered / 6 + 4 * cluster_count + 256);
  const std::uint64_t each = swept ? 8 : 2;
  candidates = std::max(
      candidates, withinLimit(each * clustered + 256, candidateBytes(swept), memory_limit_bytes));
  contacts =
      std::max(contacts, withinLimit(clustered + 256, contactBytes(swept), memory_limit_bytes));
  if (swept) open_pairs = std::max(open_pairs, clustered / 64 + 256);
  follow();
}

void CycleSizes::follow() {
  if (!swept) return;
  swept_bodies = bodies;
  swept_vertices = vertices;
  swept_members = members;
  swept_candidates = candidates;
  swept_contacts = contacts;
}

bool CycleSizes::hold(const CycleCounters& c) const {
  return c.bins_wanted <= members && c.list_words <= list_words && c.units <= units &&
         c.candidates <= candidates && c.contacts <= contacts && c.open_pairs <= open_pairs;
}

bool CycleSizes::growFor(const CycleCounters& c, std::uint64_t memory_limit_bytes) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 29;  // the sweep packs members' places
  if (c.bins_wanted >= kMost || c.list_words >= kMost || c.units >= kMost) {
    throw CudaError(
        BackendFault::kSceneTooLarge,
        "the scene is too crowded for the CUDA backend: " + std::to_string(c.bins_wanted) +
            " places in clusters, " + std::to_string(c.units) + " work units");
  }
  bool grown = grow(members, c.bins_wanted, kMost);
  grown |= grow(list_words, c.list_words, kMost);
  grown |= grow(units, c.units, kMost);
  grown |= grow(candidates, c.candidates,
                withinLimit(~std::uint64_t{0}, candidateBytes(swept), memory_limit_bytes));
  grown |= grow(contacts, c.contacts,
                withinLimit(~std::uint64_t{0}, contactBytes(swept), memory_limit_bytes));
  grown |= grow(open_pairs, c.open_pairs,
                withinLimit(~std::uint64_t{0}, sizeof(OpenPair), memory_limit_bytes));
  follow();
  return grown;
}

}  // namespace deformable_contact_monitor
