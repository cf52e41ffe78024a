#include "core/cluster_sweep.h"

#include <algorithm>
#include <chrono>
#include <cstring>

// The scan below is the hottest loop of all: let it use wide vectors where the processor has them.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define DCM_WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define DCM_WIDE_CLONES
#endif

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Unsigned integers that order as the floats do; -0 before 0.
std::uint32_t orderedBits(float x) {
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

constexpr std::uint32_t kChunk = 64;

// hit[k] = 1 iff box k, of kChunk ones, overlaps the row's on both axes.
DCM_WIDE_CLONES void markOverlaps(std::uint32_t row_lo, std::uint32_t row_hi,
                                  const std::uint32_t* __restrict lo,
                                  const std::uint32_t* __restrict hi,
                                  std::uint8_t* __restrict hit) {
  const std::uint32_t guarded = row_hi | kPackedGuard;
  for (std::uint32_t k = 0; k < kChunk; ++k) {
    const std::uint32_t both = (guarded - lo[k]) & ((hi[k] | kPackedGuard) - row_lo) & kPackedGuard;
    hit[k] = both == kPackedGuard;
  }
}

}  // namespace

Triangle CandidateJudge::received(std::uint32_t t) const {
  const WorkingSet& set = input_.set;
  const TriangleMesh& mesh = input_.scene.body(set.body[t]).mesh;
  const std::uint32_t* corner = &mesh.triangles[3 * std::size_t{set.triangle[t]}];
  Triangle triangle;
  for (int k = 0; k < 3; ++k) {
    const float* v = &mesh.vertices[3 * std::size_t{corner[k]}];
    triangle.v[k] = {v[0], v[1], v[2]};
  }
  return triangle;
}

void CandidateJudge::judge(const Contender& a, const Contender& b) {
  const std::uint32_t body_a = input_.set.body[a.triangle], body_b = input_.set.body[b.triangle];
  if (body_a == body_b) {
    SharedVertices shared = sharedVertices(a.lanes, b.lanes);
    if (shared.any && !input_.set.as_received[body_a]) {
      // Adjacency is that of the coordinates as received; posing may have made different ones
      // equal.
      shared = sharedVertices(received(a.triangle), received(b.triangle));
    }
    if (shared.any) {
      judgeAdjacent(a, b, shared);
      return;
    }
  }
  ++output_.candidates;
  const float margin_m =
      std::max(input_.scene.body(body_a).margin_m, input_.scene.body(body_b).margin_m);
  KnownSides sides;
  const bool apart = onOneSide(b.plane, a.lanes, sides.a) || onOneSide(a.plane, b.lanes, sides.b);
  if (apart && margin_m == 0) return;
  state_ = {input_.options.predicates};
  report(a, b,
         separateVerdict(input_.set.posed(a.triangle), input_.set.posed(b.triangle), sides,
                         margin_m, state_));
}

// Margins do not apply: neighbours in a mesh are always near.
void CandidateJudge::judgeAdjacent(const Contender& a, const Contender& b,
                                   const SharedVertices& shared) {
  if (input_.options.adjacent == AdjacentPairs::kSkip) return;
  ++output_.candidates;
  if (restOnOneSide(b.plane, a.lanes, shared.in_a) ||
      restOnOneSide(a.plane, b.lanes, shared.in_b)) {
    return;
  }
  state_ = {input_.options.predicates};
  report(
      a, b,
      {meetBeyondShared(input_.set.posed(a.triangle), input_.set.posed(b.triangle), shared, state_),
       0});
}

void CandidateJudge::report(const Contender& a, const Contender& b, const Verdict& verdict) {
  output_.exact += state_.exact > 0;
  if (!verdict.contact) return;
  output_.undecided += state_.undecided;
  output_.contacts.push_back(
      {std::min(a.triangle, b.triangle), std::max(a.triangle, b.triangle), verdict.separation_m});
}

void ClusterSweeper::sortMembers() {
  const ClusterAssignment& assignment = input_.assignment;
  const WorkingSet& set = input_.set;
  const std::uint32_t begin = assignment.member_begin[cluster_];
  const std::uint32_t count = assignment.member_begin[cluster_ + 1] - begin;
  const auto scaledCorners = [&](std::uint32_t t, Vec3f v[3]) {
    for (int k = 0; k < 3; ++k) v[k] = assignment.scaled[set.corners[3 * std::size_t{t} + k]];
  };

  // Axes of the centroids, about the first of them.
  Moments moments;
  Vec3f near;
  for (std::uint32_t m = 0; m < count; ++m) {
    Vec3f v[3];
    scaledCorners(input_.split.regular[assignment.members[begin + m]], v);
    const Vec3f centroid = (v[0] + v[1] + v[2]) * (1.0F / 3);
    if (m == 0) near = centroid;
    moments.add(centroid - near);
  }
  const PrincipalAxes axes = principalAxes(moments);

  members_.resize(count);
  order_.resize(count);
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  bool one_group = true;
  for (std::uint32_t m = 0; m < count; ++m) {
    Member& member = members_[m];
    member.regular = assignment.members[begin + m];
    const std::uint32_t t = input_.split.regular[member.regular];
    member.group = input_.groups.group[set.body[t]];
    one_group = one_group && member.group == members_[0].group;
    Vec3f v[3];
    scaledCorners(t, v);
    for (int k = 0; k < 3; ++k) {
      member.interval[k] = project(axes.axis[k], v, input_.slack[set.body[t]] / 2);
      low[k] = least(low[k], member.interval[k].lo);
      high[k] = most(high[k], member.interval[k].hi);
    }
    order_[m] = std::uint64_t{orderedBits(member.interval[0].lo)} << 32 | m;
  }
  std::sort(order_.begin(), order_.end());
  const auto memberAt = [this](std::uint64_t key) -> const Member& {
    return members_[static_cast<std::uint32_t>(key)];
  };
  if (!one_group) {
    std::stable_sort(order_.begin(), order_.end(), [&](std::uint64_t a, std::uint64_t b) {
      return memberAt(a).group < memberAt(b).group;
    });
  }

  const Quantiser quantiser[2] = {{low[1], high[1]}, {low[2], high[2]}};
  segments_.clear();
  lo_.resize(count);
  hi_.resize(count);
  boxes_.resize(count);
  contenders_.resize(count);
  clusters_.resize(count);
  packed_lo_.resize(count + kChunk);  // so that the last chunk may read on
  packed_hi_.resize(count + kChunk);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Member& member = memberAt(order_[i]);
    if (segments_.empty() || segments_.back().group != member.group) {
      segments_.push_back({member.group, i, i});
    }
    segments_.back().end = i + 1;
    lo_[i] = member.interval[0].lo;
    hi_[i] = member.interval[0].hi;
    const PackedBox packed = pack(quantiser, &member.interval[1]);
    packed_lo_[i] = packed.lo;
    packed_hi_[i] = packed.hi;
    const std::uint32_t t = input_.split.regular[member.regular];
    boxes_[i] = set.boxes[t];
    contenders_[i] = Contender(set, t);
    clusters_[i] = &assignment.clusters[assignment.list_begin[member.regular]];
  }
}

void ClusterSweeper::scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end) {
  if (begin == end) return;
  output_.interval_overlaps += end - begin;
  // Room for all that can come, so that writing a hit is one store.
  const std::size_t room = hit_count_ + (end - begin);
  if (hits_.size() < room) hits_.resize(2 * room);
  Hit* next = &hits_[hit_count_];
  for (std::uint32_t chunk = begin; chunk < end; chunk += kChunk) {
    std::uint8_t hit[kChunk];
    markOverlaps(packed_lo_[row], packed_hi_[row], &packed_lo_[chunk], &packed_hi_[chunk], hit);
    for (std::uint32_t k = 0; k < kChunk && chunk + k < end; k += 8) {
      std::uint64_t word;
      std::memcpy(&word, hit + k, 8);
      for (; word != 0; word &= word - 1) {
        const std::uint32_t column =
            chunk + k + static_cast<std::uint32_t>(__builtin_ctzll(word)) / 8;
        if (column < end) *next++ = {row, column};
      }
    }
  }
  hit_count_ = static_cast<std::size_t>(next - hits_.data());
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
  const std::uint32_t *x = clusters_[a], *y = clusters_[b];
  while (*x != *y) {  // both lists hold this cluster, so this ends
    if (*x < *y) {
      ++x;
    } else {
      ++y;
    }
  }
  return *x == cluster_;
}

void ClusterSweeper::judgeHits() {
  const auto start = Clock::now();
  CandidateJudge judge(input_, output_);
  for (std::size_t h = 0; h < hit_count_; ++h) {
    const Hit hit = hits_[h];
    if (overlap(boxes_[hit.a], boxes_[hit.b]) && owns(hit.a, hit.b)) {
      judge.judge(contenders_[hit.a], contenders_[hit.b]);
    }
  }
  hit_count_ = 0;
  output_.narrow_ms += millisecondsSince(start);
}

void ClusterSweeper::sweep(std::uint32_t cluster) {
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
