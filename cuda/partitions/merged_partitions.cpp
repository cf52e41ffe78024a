#include "cuda/partitions/merged_partitions.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/common/parallel.h"

namespace deformable_contact_monitor {
namespace {

using Shares = std::vector<const DetectionResult*>;

// A part of the whole list: from where to where in each share's, and where it begins.
struct Part {
  std::vector<std::size_t> begin, end;
  std::size_t to = 0;
};

// Calls take(share, first, count, to) for runs of contacts of one share, in the order of the whole.
template <class Take>
void forEachRun(const Shares& shares, const Part& part, const Take& take) {
  std::vector<std::size_t> at = part.begin;
  std::size_t to = part.to;
  while (true) {
    const TrianglePair* least = nullptr;
    const TrianglePair* next = nullptr;  // of the other shares
    std::size_t from = 0;
    for (std::size_t s = 0; s < shares.size(); ++s) {
      if (at[s] == part.end[s]) continue;
      const TrianglePair* const head = &shares[s]->contacts[at[s]];
      if (least == nullptr || *head < *least) {
        next = least;
        least = head;
        from = s;
      } else if (next == nullptr || *head < *next) {
        next = head;
      }
    }
    if (least == nullptr) return;
    const HostList<TrianglePair>& contacts = shares[from]->contacts;
    const std::size_t first = at[from];
    std::size_t last = part.end[from];
    if (next != nullptr) {
      last = first + 1;
      while (last < part.end[from] && contacts[last] < *next) ++last;
    }
    take(from, first, last - first, to);
    to += last - first;
    at[from] = last;
  }
}

// Cuts the lists at the same contacts, so that the parts of the whole can be written at once.
std::vector<Part> cutIntoParts(const Shares& shares) {
  constexpr std::size_t kOfOnePart = 1 << 13;
  const auto size = [](const DetectionResult* share) { return share->contacts.size(); };
  const DetectionResult& longest = **std::max_element(
      shares.begin(), shares.end(),
      [&](const DetectionResult* a, const DetectionResult* b) { return size(a) < size(b); });
  std::vector<Part> parts;
  std::vector<std::size_t> begin(shares.size(), 0);
  std::size_t to = 0;
  for (std::size_t cut = kOfOnePart;; cut += kOfOnePart) {
    const bool last = cut >= longest.contacts.size();
    Part part{begin, {}, to};
    for (std::size_t s = 0; s < shares.size(); ++s) {
      const HostList<TrianglePair>& contacts = shares[s]->contacts;
      const auto from = contacts.begin() + static_cast<std::ptrdiff_t>(begin[s]);
      const auto until =
          last ? contacts.end() : std::lower_bound(from, contacts.end(), longest.contacts[cut]);
      part.end.push_back(static_cast<std::size_t>(until - contacts.begin()));
      to += part.end[s] - begin[s];
    }
    begin = part.end;
    parts.push_back(std::move(part));
    if (last) return parts;
  }
}

// Whether each contact of each share has an item in that list.
template <class List>
bool isThere(const Shares& shares, List DetectionResult::*list) {
  return std::all_of(shares.begin(), shares.end(), [list](const DetectionResult* share) {
    return (share->*list).size() == share->contacts.size();
  });
}

class ListMerger {
 public:
  ListMerger(const Shares& shares, DetectionResult& whole)
      : shares_(shares), whole_(whole), parts_(cutIntoParts(shares)) {
    for (const DetectionResult* share : shares) total_ += share->contacts.size();
  }

  template <class List>
  void merge(List DetectionResult::*list) const {
    if (!isThere(shares_, list)) return;
    (whole_.*list).resize(total_);
    parallelBlocks(parts_.size(), 1, [&](std::size_t block, std::size_t, std::size_t) {
      forEachRun(shares_, parts_[block],
                 [&](std::size_t share, std::size_t first, std::size_t count, std::size_t to) {
                   std::copy_n((shares_[share]->*list).begin() + static_cast<std::ptrdiff_t>(first),
                               count, (whole_.*list).begin() + static_cast<std::ptrdiff_t>(to));
                 });
    });
  }

 private:
  const Shares& shares_;
  DetectionResult& whole_;
  const std::vector<Part> parts_;
  std::size_t total_ = 0;
};

void addCounters(const Counters& share, Counters& whole) {
  // Every device looks at all triangles for these.
  whole.rejected = share.rejected;
  whole.posed = share.posed;
  whole.culled = share.culled;
  whole.clustered += share.clustered;
  whole.large += share.large;
  whole.clusters += share.clusters;
  whole.cluster_entries += share.cluster_entries;
  whole.largest_cluster = std::max(whole.largest_cluster, share.largest_cluster);
  whole.interval_overlaps += share.interval_overlaps;
  whole.candidates += share.candidates;
  whole.exact += share.exact;
  whole.undecided += share.undecided;
}

void addTimes(const DetectionResult& share, DetectionResult& whole) {
  whole.detect_ms = std::max(whole.detect_ms, share.detect_ms);
  for (const auto& its : share.stages_ms) {
    const auto found = std::find_if(whole.stages_ms.begin(), whole.stages_ms.end(),
                                    [&](const auto& stage) { return stage.first == its.first; });
    if (found == whole.stages_ms.end()) {
      whole.stages_ms.push_back(its);
    } else {
      found->second = std::max(found->second, its.second);
    }
  }
}

}  // namespace

void mergeShares(const std::vector<const DetectionResult*>& shares, DetectionResult& whole) {
  for (const DetectionResult* share : shares) {
    addCounters(share->counters, whole.counters);
    addTimes(*share, whole);
    whole.left_out += share->left_out;
    whole.memory_bytes += share->memory_bytes;
    whole.started_cold = whole.started_cold || share->started_cold;
    if (share->cut_off) whole.cutOff(share->cut_off_because);
  }
  const ListMerger lists(shares, whole);
  lists.merge(&DetectionResult::contacts);
  lists.merge(&DetectionResult::separations_m);
  lists.merge(&DetectionResult::geometry);
  lists.merge(&DetectionResult::first_times);
  lists.merge(&DetectionResult::within_pad);
}

}  // namespace deformable_contact_monitor
