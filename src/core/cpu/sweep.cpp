#include "core/cpu/sweep.h"

#include <algorithm>
#include <chrono>

#include "core/rules/half_space.h"
#include "core/rules/ordered_bits.h"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

void ClusterSweeper::sortMembers() {
  const ClusterAssignment& assignment = input_.assignment;
  const ClusterMember* const members = &assignment.members[assignment.member_begin[cluster_]];
  const std::uint32_t count =
      assignment.member_begin[cluster_ + 1] - assignment.member_begin[cluster_];
  projected_.resize(count);
  order_.resize(count);

  // Axes of the centroids, about the first of them.
  Moments moments;
  Vec3f near;
  for (std::uint32_t m = 0; m < count; ++m) {
    Vec3f* v = projected_[m].scaled;
    for (int k = 0; k < 3; ++k) v[k] = input_.split.scale.apply(members[m].posed.v[k]);
    const Vec3f centroid = (v[0] + v[1] + v[2]) * (1.0F / 3);
    if (m == 0) near = centroid;
    moments.add(centroid - near);
  }
  const PrincipalAxes axes = principalAxes(moments);

  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  bool one_group = true;
  for (std::uint32_t m = 0; m < count; ++m) {
    Projected& projected = projected_[m];
    const std::uint32_t body = members[m].body;
    projected.group = input_.groups.group[body];
    one_group = one_group && projected.group == projected_[0].group;
    for (int k = 0; k < 3; ++k) {
      projected.interval[k] = project(axes.axis[k], projected.scaled, input_.slack[body] / 2);
      low[k] = least(low[k], projected.interval[k].lo);
      high[k] = most(high[k], projected.interval[k].hi);
    }
    order_[m] = std::uint64_t{orderedBits(projected.interval[0].lo)} << 32 | m;
  }
  std::sort(order_.begin(), order_.end());
  const auto memberOf = [](std::uint64_t key) { return static_cast<std::uint32_t>(key); };
  if (!one_group) {
    std::stable_sort(order_.begin(), order_.end(), [&](std::uint64_t a, std::uint64_t b) {
      return projected_[memberOf(a)].group < projected_[memberOf(b)].group;
    });
  }

  const Quantiser quantiser[2] = {{low[1], high[1]}, {low[2], high[2]}};
  segments_.clear();
  lo_.resize(count);
  hi_.resize(count);
  boxes_.resize(count);
  contenders_.resize(count);
  clusters_.resize(count);
  alone_.resize(count);
  packed_lo_.resize(count + kScanChunk);  // so that the last chunk may read on
  packed_hi_.resize(count + kScanChunk);
  for (std::uint32_t i = 0; i < count; ++i) {
    const ClusterMember& member = members[memberOf(order_[i])];
    const Projected& projected = projected_[memberOf(order_[i])];
    if (segments_.empty() || segments_.back().group != projected.group) {
      segments_.push_back({projected.group, i, i});
    }
    segments_.back().end = i + 1;
    lo_[i] = projected.interval[0].lo;
    hi_[i] = projected.interval[0].hi;
    const PackedBox packed = pack(quantiser, &projected.interval[1]);
    packed_lo_[i] = packed.lo;
    packed_hi_[i] = packed.hi;
    contenders_[i] = Contender(member.posed, member.vertex_id, member.triangle, member.body);
    // Not looked up: computing it is faster than a cache miss.
    boxes_[i] = inflated(boxOf(member.posed), input_.scene.body(member.body).margin_m);
    clusters_[i] = &assignment.lists[member.list_begin];
    alone_[i] = static_cast<char>(member.list_size == 1);
  }
}

void ClusterSweeper::scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
  if (begin == end) return;
  output_.interval_overlaps += end - begin;
  const std::size_t room = hit_count_ + (end - begin) + kScanChunk;
  if (hits_.size() < room) hits_.resize(2 * room);
  hit_count_ += scanRow(row, {packed_lo_[row], packed_hi_[row]}, packed_lo_.data(),
                        packed_hi_.data(), begin, end, &hits_[hit_count_]);
  constexpr std::size_t kMostHits = 1 << 20;  // bounds the memory of dense clusters
  if (hit_count_ > kMostHits) judgeHits();
}

// Each unordered pair once: the partner begins later in the order.
void ClusterSweeper::sweepWithin(const Segment& s) {
  for (std::uint32_t i = s.begin; i < s.end; ++i) {
    const auto last = std::upper_bound(lo_.begin() + i + 1, lo_.begin() + s.end, hi_[i]);
    scan(i, i + 1, static_cast<std::uint32_t>(last - lo_.begin()));
  }
}

// Pairs whose column begins within the row's interval; `closed`: also where both begin together.
void ClusterSweeper::sweepAcross(const Segment& rows, const Segment& columns, bool closed) {
  const auto columns_end = lo_.begin() + columns.end;
  auto first = lo_.begin() + columns.begin;
  for (std::uint32_t i = rows.begin; i < rows.end; ++i) {
    while (first != columns_end && (closed ? *first < lo_[i] : *first <= lo_[i])) ++first;
    const auto last = std::upper_bound(first, columns_end, hi_[i]);
    scan(i, static_cast<std::uint32_t>(first - lo_.begin()),
         static_cast<std::uint32_t>(last - lo_.begin()));
  }
}

// A pair is reported only in the lowest cluster that its triangles have in common.
bool ClusterSweeper::owns(std::uint32_t a, std::uint32_t b) const {
  return lowestCommon(clusters_[a], clusters_[b]) == cluster_;
}

void ClusterSweeper::judgeHits() {
  const auto start = Clock::now();
  std::size_t kept = 0;
  for (std::size_t h = 0; h < hit_count_; ++h) {
    const Hit hit = hits_[h];
    const bool owned = alone_[hit.a] != 0 || alone_[hit.b] != 0 || owns(hit.a, hit.b);
    hits_[kept] = hit;
    kept += overlap(boxes_[hit.a], boxes_[hit.b]) & owned;
  }
  judge_.judge(contenders_, hits_.data(), kept);
  hit_count_ = 0;
  output_.narrow_ms += millisecondsSince(start);
}

void ClusterSweeper::sweep(std::uint32_t cluster) {
  const std::vector<std::uint32_t>& begin = input_.assignment.member_begin;
  if (begin[cluster] == begin[cluster + 1]) return;
  cluster_ = cluster;
  const auto start = Clock::now();
  sortMembers();
  output_.sort_ms += millisecondsSince(start);

  const auto sweep_start = Clock::now();
  const double narrow_before = output_.narrow_ms;
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    if (input_.groups.enabled[segments_[s].group][segments_[s].group]) sweepWithin(segments_[s]);
    for (std::size_t t = s + 1; t < segments_.size(); ++t) {
      if (!input_.groups.enabled[segments_[s].group][segments_[t].group]) continue;
      sweepAcross(segments_[s], segments_[t], true);
      sweepAcross(segments_[t], segments_[s], false);
    }
  }
  output_.sweep_ms += millisecondsSince(sweep_start) - (output_.narrow_ms - narrow_before);
  judgeHits();
}

}  // namespace deformable_contact_monitor
