// Merges sorted lists of contacts. The lists are cut into parts at common contacts, so that several
// threads can merge the parts at once. Each part is merged by runs: as many contacts of one
// partition as come before the next contact of any other one.
#include "cuda/partitions/merged_partitions.h"

#include <algorithm>
#include <cstddef>

#include "core/common/parallel.h"

namespace deformable_contact_monitor {
namespace {

using PartResults = std::vector<const DetectionResult*>;

// One part of the merged list: contacts [begin[s], end[s]) of each partition s. Its first contact
// has place `to` in the merged list.
struct Part {
  std::vector<std::size_t> begin, end;
  std::size_t to = 0;
};

// Calls take(partition, first, count, to) for each run of a part, in the order of the merged list.
// A run consists of contacts [first, first + count) of one partition; its first contact has place
// `to` in the merged list.
template <class Take>
void forEachRun(const PartResults& partitions, const Part& part, const Take& take) {
  std::vector<std::size_t> at = part.begin;
  std::size_t to = part.to;
  while (true) {
    const TrianglePair* least = nullptr;
    // The least contact among the other partitions: the run ends before it.
    const TrianglePair* next = nullptr;
    std::size_t from = 0;
    for (std::size_t s = 0; s < partitions.size(); ++s) {
      if (at[s] == part.end[s]) continue;
      const TrianglePair* const head = &partitions[s]->contacts[at[s]];
      if (least == nullptr || *head < *least) {
        next = least;
        least = head;
        from = s;
      } else if (next == nullptr || *head < *next) {
        next = head;
      }
    }
    if (least == nullptr) return;
    const HostList<TrianglePair>& contacts = partitions[from]->contacts;
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

// Cuts all lists before the same contacts, so that the parts are independent of each other. The
// cuts are every kOfOnePart contacts of the longest list. Other lists are cut by a binary search.
std::vector<Part> cutIntoParts(const PartResults& partitions) {
  constexpr std::size_t kOfOnePart = 1 << 13;
  const auto size = [](const DetectionResult* partition) { return partition->contacts.size(); };
  const DetectionResult& longest = **std::max_element(
      partitions.begin(), partitions.end(),
      [&](const DetectionResult* a, const DetectionResult* b) { return size(a) < size(b); });
  std::vector<Part> parts;
  std::vector<std::size_t> begin(partitions.size(), 0);
  std::size_t to = 0;
  for (std::size_t cut = kOfOnePart;; cut += kOfOnePart) {
    const bool last = cut >= longest.contacts.size();
    Part part{begin, {}, to};
    for (std::size_t s = 0; s < partitions.size(); ++s) {
      const HostList<TrianglePair>& contacts = partitions[s]->contacts;
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

// Returns whether the optional list `list` has one item for each contact, in every partition.
template <class List>
bool isThere(const PartResults& partitions, List DetectionResult::*list) {
  return std::all_of(partitions.begin(), partitions.end(),
                     [list](const DetectionResult* partition) {
                       return (partition->*list).size() == partition->contacts.size();
                     });
}

// Merges lists of DetectionResult that run parallel to `contacts`. The parts are found once, from
// the contacts, and hold for all of these lists.
class ListMerger {
 public:
  ListMerger(const PartResults& partitions, DetectionResult& whole)
      : partitions_(partitions), whole_(whole), parts_(cutIntoParts(partitions)) {
    for (const DetectionResult* partition : partitions) total_ += partition->contacts.size();
  }

  // Fills in a list of the merged result, on several threads. Leaves it alone if some partition
  // does not have that list.
  template <class List>
  void merge(List DetectionResult::*list) const {
    if (!isThere(partitions_, list)) return;
    (whole_.*list).resize(total_);
    parallelBlocks(parts_.size(), 1, [&](std::size_t block, std::size_t, std::size_t) {
      forEachRun(partitions_, parts_[block],
                 [&](std::size_t partition, std::size_t first, std::size_t count, std::size_t to) {
                   std::copy_n(
                       (partitions_[partition]->*list).begin() + static_cast<std::ptrdiff_t>(first),
                       count, (whole_.*list).begin() + static_cast<std::ptrdiff_t>(to));
                 });
    });
  }

 private:
  const PartResults& partitions_;
  DetectionResult& whole_;
  const std::vector<Part> parts_;
  std::size_t total_ = 0;
};

void addCounters(const Counters& part, Counters& whole) {
  // Each device transforms and culls all triangles of the scene, so these three are equal in all
  // partitions and are not added up.
  whole.rejected = part.rejected;
  whole.posed = part.posed;
  whole.culled = part.culled;
  whole.clusters += part.clusters;
  whole.addWork(part);
}

// Takes the longest time of each stage [ms], because the devices work at the same time.
void addTimes(const DetectionResult& partition, DetectionResult& whole) {
  whole.detect_ms = std::max(whole.detect_ms, partition.detect_ms);
  for (const auto& its : partition.stages_ms) {
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

void mergePartitions(const std::vector<const DetectionResult*>& partitions,
                     DetectionResult& whole) {
  whole.memory_is_whole = true;
  for (const DetectionResult* partition : partitions) {
    addCounters(partition->counters, whole.counters);
    addTimes(*partition, whole);
    whole.left_out += partition->left_out;
    whole.memory_bytes += partition->memory_bytes;
    whole.memory_is_whole = whole.memory_is_whole && partition->memory_is_whole;
    whole.detector_bytes += partition->detector_bytes;
    whole.started_cold = whole.started_cold || partition->started_cold;
    if (partition->cut_off) whole.cutOff(partition->cut_off_because);
  }
  // The first device searches them in the whole scene; the others do not.
  whole.nearest = partitions.front()->nearest;
  whole.nearest_parts = partitions.front()->nearest_parts;
  whole.rejected_parts = partitions.front()->rejected_parts;  // each device sees all triangles
  const ListMerger lists(partitions, whole);
  lists.merge(&DetectionResult::contacts);
  lists.merge(&DetectionResult::separations_m);
  lists.merge(&DetectionResult::geometry);
  lists.merge(&DetectionResult::first_times);
  lists.merge(&DetectionResult::within_pad);
}

}  // namespace deformable_contact_monitor
