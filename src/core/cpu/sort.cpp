#include "core/cpu/sort.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "core/cpu/radix_sort.h"
#include "core/rules/principal_axes.h"

namespace deformable_contact_monitor {
namespace {

// Returns which clusters of an ascending list, which contains `cluster`, are lower than it.
LowerClusters lowerThan(ClusterIndex cluster, const std::uint32_t* list) {
  if (list[0] == cluster.value) return kNoLower;
  return list[1] == cluster.value ? list[0] : kSeveralLower;
}

// Returns the entry number of a sort key.
std::uint32_t entryOf(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

// Fills in the parts of the triangles of a cluster that is laid out.
template <class Primitive>
void noteParts(const WorkingSet& set, SortedCluster<Primitive>& sorted) {
  sorted.parts.resize(sorted.triangles.size());
  for (std::size_t i = 0; i < sorted.triangles.size(); ++i) {
    sorted.parts[i] = set.part[sorted.triangles[i].triangle.value];
  }
}

}  // namespace

// Computes the cluster's principal axes and projects its entries onto them. Fills in projected_,
// the keys in order_ and the quantisers of the second and third axis.
template <class Primitive>
void ClusterSorter<Primitive>::project(const ClusterEntry<Primitive>* entries) {
  const auto count = static_cast<std::uint32_t>(projected_.size());
  // The axes are those of the centroids, about the first of them.
  Moments moments;
  Vec3f first;
  for (std::uint32_t m = 0; m < count && !pace_.over(); ++m) {
    Vec3f* scaled = projected_[m].scaled;
    input_.split.scaled(entries[m].posed, scaled);
    const Vec3f centroid = meanOf<Primitive>(scaled);
    if (m == 0) first = centroid;
    moments.add(centroid - first);
  }
  const PrincipalAxes axes = principalAxes(covarianceOf(moments));

  float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  one_group_ = true;
  for (std::uint32_t m = 0; m < count && !pace_.over(); ++m) {
    Projected& projected = projected_[m];
    const std::uint32_t body = entries[m].body.value;
    projected.group = input_.groups.group[body];
    one_group_ = one_group_ && projected.group == projected_[0].group;
    const float growth = input_.slack[body] / 2;
    projected.interval = deformable_contact_monitor::project<kPoints<Primitive>>(
        axes.axis[0], projected.scaled, growth);
    for (int s = 0; s < kStates<Primitive>; ++s) {
      for (int k = 0; k < 2; ++k) {
        const Interval across =
            deformable_contact_monitor::project(axes.axis[k + 1], projected.scaled + 3 * s, growth);
        projected.across[s][k] = across;
        low[k] = least(low[k], across.lo);
        high[k] = most(high[k], across.hi);
      }
    }
    order_[m] = std::uint64_t{orderedBits(projected.interval.lo)} << 32 | m;
  }
  for (int k = 0; k < 2; ++k) quantiser_[k] = {low[k], high[k]};
}

// Orders the entries by where their intervals begin, and then, stably, by body group.
template <class Primitive>
void ClusterSorter<Primitive>::order() {
  sortByUpperHalf(input_.limit, order_, scratch_);
  if (one_group_ || input_.limit.wasOver()) return;
  const auto by_group = [this](std::uint64_t a, std::uint64_t b) {
    return projected_[entryOf(a)].group < projected_[entryOf(b)].group;
  };
  sortWithin(input_.limit, order_.size(), by_group,
             [this](const auto& less) { std::stable_sort(order_.begin(), order_.end(), less); });
}

// Copies everything to its place in `sorted`.
template <class Primitive>
void ClusterSorter<Primitive>::layOut(ClusterIndex cluster, const ClusterEntry<Primitive>* entries,
                                      SortedCluster<Primitive>& sorted) {
  sorted.cluster = cluster;
  const auto count = static_cast<std::uint32_t>(order_.size());
  sorted.groups.clear();
  sorted.lo.resize(count + kScanChunk);
  sorted.hi.resize(count);
  for (int s = 0; s < kStates<Primitive>; ++s) {
    sorted.packed_lo[s].resize(count + kScanChunk);
    sorted.packed_hi[s].resize(count + kScanChunk);
  }
  resizeWithin(input_.limit, count, sorted.boxes);
  resizeWithin(input_.limit, count, sorted.triangles);
  sorted.clusters.resize(count);
  sorted.lower.resize(count);
  if (input_.limit.wasOver()) return;
  for (std::uint32_t i = 0; i < count && !pace_.over(); ++i) {
    const ClusterEntry<Primitive>& entry = entries[entryOf(order_[i])];
    const Projected& projected = projected_[entryOf(order_[i])];
    if (sorted.groups.empty() || sorted.groups.back().group != projected.group) {
      sorted.groups.push_back({projected.group, i, i});
    }
    sorted.groups.back().end = i + 1;
    sorted.lo[i] = projected.interval.lo;
    sorted.hi[i] = projected.interval.hi;
    for (int s = 0; s < kStates<Primitive>; ++s) {
      const PackedBox packed = pack(quantiser_, projected.across[s]);
      sorted.packed_lo[s][i] = packed.lo;
      sorted.packed_hi[s][i] = packed.hi;
    }
    // The box is computed again: that is faster than a cache miss.
    sorted.boxes[i] = boxLanes(
        entry.posed, growthOf<Primitive>(input_.scene.body(entry.body.value), input_.options));
    // It is constructed in place. A copy from the stack would wait for vectors that were written in
    // halves.
    new (&sorted.triangles[i])
        PreparedTriangle<Primitive>(entry.posed, entry.vertex_id, entry.triangle, entry.body);
    sorted.clusters[i] = &input_.assignment.lists[entry.list_begin];
    sorted.lower[i] = entry.list_size == 1 ? kNoLower : lowerThan(cluster, sorted.clusters[i]);
  }
}

// Takes one cluster through the three steps; each may be cut short by the limit.
template <class Primitive>
bool ClusterSorter<Primitive>::sort(ClusterIndex cluster, SortedCluster<Primitive>& sorted) {
  const ClusterAssignment<Primitive>& assignment = input_.assignment;
  const std::uint32_t begin = assignment.entry_begin[cluster.value];
  const std::uint32_t count = assignment.entry_begin[cluster.value + 1] - begin;
  const ClusterEntry<Primitive>* const entries = assignment.entries.data() + begin;
  resizeWithin(input_.limit, count, projected_);
  order_.resize(count);
  if (input_.limit.wasOver()) return false;
  project(entries);
  if (input_.limit.wasOver()) return false;
  order();
  if (input_.limit.wasOver()) return false;
  layOut(cluster, entries, sorted);
  if (input_.limit.wasOver()) return false;
  if (input_.set.parts != nullptr) noteParts(input_.set, sorted);
  return true;
}

template class ClusterSorter<Triangle>;
template class ClusterSorter<MovingTriangle>;

}  // namespace deformable_contact_monitor
