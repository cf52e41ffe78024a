#include "core/cpu/sort.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "core/cpu/radix_sort.h"
#include "core/rules/ordered_bits.h"
#include "core/rules/principal_axes.h"

namespace deformable_contact_monitor {
namespace {

// Of an ascending list that holds the cluster.
LowerClusters lowerThan(ClusterIndex cluster, const std::uint32_t* list) {
  if (list[0] == cluster.value) return kNoLower;
  return list[1] == cluster.value ? list[0] : kSeveralLower;
}

// The lower half of a key.
std::uint32_t memberOf(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

}  // namespace

// Fills projected_, the keys of order_, and what the other two axes are quantised by.
template <class Hull>
void ClusterSorter<Hull>::project(const ClusterMember<Hull>* members) {
  const auto count = static_cast<std::uint32_t>(projected_.size());
  // Axes of the centroids, about the first of them.
  Moments moments;
  Vec3f first;
  for (std::uint32_t m = 0; m < count && !pace_.over(); ++m) {
    Vec3f* scaled = projected_[m].scaled;
    input_.split.scaled(members[m].posed, scaled);
    const Vec3f centroid = meanOf<Hull>(scaled);
    if (m == 0) first = centroid;
    moments.add(centroid - first);
  }
  const PrincipalAxes axes = principalAxes(covarianceOf(moments));

  float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  one_group_ = true;
  for (std::uint32_t m = 0; m < count && !pace_.over(); ++m) {
    Projected& projected = projected_[m];
    const std::uint32_t body = members[m].body.value;
    projected.group = input_.groups.group[body];
    one_group_ = one_group_ && projected.group == projected_[0].group;
    const float growth = input_.slack[body] / 2;
    projected.interval =
        deformable_contact_monitor::project<kPoints<Hull>>(axes.axis[0], projected.scaled, growth);
    for (int s = 0; s < kStates<Hull>; ++s) {
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

template <class Hull>
void ClusterSorter<Hull>::order() {
  sortByUpperHalf(input_.limit, order_, scratch_);
  if (one_group_ || input_.limit.wasOver()) return;
  const auto by_group = [this](std::uint64_t a, std::uint64_t b) {
    return projected_[memberOf(a)].group < projected_[memberOf(b)].group;
  };
  sortWithin(input_.limit, order_.size(), by_group,
             [this](const auto& less) { std::stable_sort(order_.begin(), order_.end(), less); });
}

// All of `sorted`.
template <class Hull>
void ClusterSorter<Hull>::layOut(ClusterIndex cluster, const ClusterMember<Hull>* members,
                                 SortedCluster<Hull>& sorted) {
  sorted.cluster = cluster;
  const auto count = static_cast<std::uint32_t>(order_.size());
  sorted.groups.clear();
  sorted.lo.resize(count + kScanChunk);
  sorted.hi.resize(count);
  for (int s = 0; s < kStates<Hull>; ++s) {
    sorted.packed_lo[s].resize(count + kScanChunk);
    sorted.packed_hi[s].resize(count + kScanChunk);
  }
  resizeWithin(input_.limit, count, sorted.boxes);
  resizeWithin(input_.limit, count, sorted.triangles);
  sorted.clusters.resize(count);
  sorted.lower.resize(count);
  if (input_.limit.wasOver()) return;
  for (std::uint32_t i = 0; i < count && !pace_.over(); ++i) {
    const ClusterMember<Hull>& member = members[memberOf(order_[i])];
    const Projected& projected = projected_[memberOf(order_[i])];
    if (sorted.groups.empty() || sorted.groups.back().group != projected.group) {
      sorted.groups.push_back({projected.group, i, i});
    }
    sorted.groups.back().end = i + 1;
    sorted.lo[i] = projected.interval.lo;
    sorted.hi[i] = projected.interval.hi;
    for (int s = 0; s < kStates<Hull>; ++s) {
      const PackedBox packed = pack(quantiser_, projected.across[s]);
      sorted.packed_lo[s][i] = packed.lo;
      sorted.packed_hi[s][i] = packed.hi;
    }
    // Not looked up: computing it is faster than a cache miss.
    sorted.boxes[i] = boxLanes(member.posed, growthOf<Hull>(input_.scene.body(member.body.value)));
    // In place, for by way of the stack it waits for each half-written vector.
    new (&sorted.triangles[i])
        PreparedTriangle<Hull>(member.posed, member.vertex_id, member.triangle, member.body);
    sorted.clusters[i] = &input_.assignment.lists[member.list_begin];
    sorted.lower[i] = member.list_size == 1 ? kNoLower : lowerThan(cluster, sorted.clusters[i]);
  }
}

template <class Hull>
bool ClusterSorter<Hull>::sort(ClusterIndex cluster, SortedCluster<Hull>& sorted) {
  const ClusterAssignment<Hull>& assignment = input_.assignment;
  const std::uint32_t begin = assignment.member_begin[cluster.value];
  const std::uint32_t count = assignment.member_begin[cluster.value + 1] - begin;
  const ClusterMember<Hull>* const members = assignment.members.data() + begin;
  resizeWithin(input_.limit, count, projected_);
  order_.resize(count);
  if (input_.limit.wasOver()) return false;
  project(members);
  if (input_.limit.wasOver()) return false;
  order();
  if (input_.limit.wasOver()) return false;
  layOut(cluster, members, sorted);
  return !input_.limit.wasOver();
}

template class ClusterSorter<Triangle>;
template class ClusterSorter<MovingTriangle>;

}  // namespace deformable_contact_monitor
