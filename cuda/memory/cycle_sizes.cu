#include <algorithm>
#include <string>

#include "core/rules/sampling.h"
#include "cuda/device/cuda_error.h"
#include "cuda/memory/contact_arrays.cuh"
#include "cuda/memory/cycle_sizes.cuh"

namespace deformable_contact_monitor {
namespace {

// What a candidate and a contact take, with the arrays that go with them [bytes].
constexpr std::uint64_t kCandidateBytes = sizeof(DeviceCandidate) + sizeof(std::uint32_t);
constexpr std::uint64_t kContactBytes =  // the list, the sorted one, and what sorting needs
    3 * (sizeof(std::uint64_t) + sizeof(float));

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
  candidates =
      std::max(candidates, withinLimit(2 * clustered + 256, kCandidateBytes, memory_limit_bytes));
  contacts = std::max(contacts, withinLimit(clustered + 256, kContactBytes, memory_limit_bytes));
}

bool CycleSizes::hold(const CycleCounters& c) const {
  return c.bins_wanted <= members && c.list_words <= list_words && c.units <= units &&
         c.candidates <= candidates && c.contacts <= contacts;
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
                withinLimit(~std::uint64_t{0}, kCandidateBytes, memory_limit_bytes));
  grown |=
      grow(contacts, c.contacts, withinLimit(~std::uint64_t{0}, kContactBytes, memory_limit_bytes));
  return grown;
}

}  // namespace deformable_contact_monitor
