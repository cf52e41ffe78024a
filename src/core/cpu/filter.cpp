#include "core/cpu/filter.h"

#include <algorithm>

#include "core/common/lanes.h"
#include "core/cpu/lane_crossing.h"
#include "core/predicates/vertex_fan.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {

namespace {

using Prepared = PreparedTriangle<Triangle>;
using SidedPair = FilterBuffers<Triangle>::SidedPair;

// Returns whether one of the shared vertices has a certified fan: triangles that share it then meet
// only in what they share.
bool isCertified(const Prepared& a, int shared_bits) {
  static_assert(kFanCertified == std::uint32_t{1} << 31, "the sign");
  return (laneBits(a.vertex_id < 0) & shared_bits) != 0;
}

// Converts the sides from bits in lanes to the form that the predicates take.
KnownSides knownSides(const PlaneSides& sides_a, const PlaneSides& sides_b) {
  KnownSides sides;
  for (int i = 0; i < 3; ++i) {
    sides.a[i] = sides_a.of(i);
    sides.b[i] = sides_b.of(i);
  }
  return sides;
}

// Writes to `left` the pairs that the plane of the row does not separate, or with `all` every pair,
// and returns their number. The row's plane stays in registers.
DCM_WIDE_CLONES std::size_t dropByRows(const Prepared* triangles, const BoxPair* pairs,
                                       std::size_t count, bool all, SidedPair* left) {
  SidedPair* next = left;
  for (std::size_t i = 0; i < count;) {
    const SortedIndex row = pairs[i].a;
    const PlaneFilter plane = triangles[row.value].plane;
    for (; i < count && pairs[i].a == row; ++i) {
      const PlaneSides sides = sidesOf(plane, triangles[pairs[i].b.value].lanes);
      *next = {pairs[i], {}, sides};
      next += !sides.allOnOne() | all;
    }
  }
  return static_cast<std::size_t>(next - left);
}

// Sorts out the pairs in `open` by the plane of their column. Pairs that it separates are dropped,
// unless `all`. With `decides`, pairs of which no vertex may lie in the other's plane move to
// `crossing`. The others stay at the front of `open`.
DCM_WIDE_CLONES void dropByColumns(const Prepared* triangles, std::size_t count, bool all,
                                   bool decides, SidedPair* open, std::size_t& open_count,
                                   SidedPair* crossing, std::size_t& crossing_count) {
  std::size_t opens = 0, crossings = 0;
  for (std::size_t i = 0; i < count; ++i) {
    SidedPair sided = open[i];
    sided.a = sidesOf(triangles[sided.pair.b.value].plane, triangles[sided.pair.a.value].lanes);
    const bool strict = sided.a.allStrict() & sided.b.allStrict() & decides;
    const bool keep = !sided.a.allOnOne() | all;
    open[opens] = crossing[crossings] = sided;
    opens += keep & !strict;
    crossings += keep & strict;
  }
  open_count = opens;
  crossing_count = crossings;
}

}  // namespace

PairFilter<Triangle>::PairFilter(const CycleInput<Triangle>& input,
                                 FilterBuffers<Triangle>& buffers)
    : input_(input),
      margins_(listsNearPairs(input.scene, input.options)),
      decides_(!margins_),
      adjacent_(buffers.adjacent),
      open_(buffers.open),
      crossing_(buffers.crossing) {}

// Splits the pairs: those that share a vertex and may meet beyond it go to adjacent_; those that
// share none are moved to the front of `pairs`, and their number is returned.
std::size_t PairFilter<Triangle>::splitAdjacent(const std::vector<Prepared>& triangles,
                                                BoxPair* pairs, std::size_t count,
                                                std::size_t& adjacent) {
  if (adjacent_.size() < count) adjacent_.resize(count);
  const bool wants_adjacent = input_.options.adjacent == AdjacentPairs::kBeyondShared;
  std::size_t separate = 0;
  adjacent = 0;
  for (std::size_t i = 0; i < count;) {
    const SortedIndex row = pairs[i].a;
    const IntLanes id = triangles[row.value].vertex_id;
    for (; i < count && pairs[i].a == row; ++i) {
      const BoxPair pair = pairs[i];
      const IntLanes& other = triangles[pair.b.value].vertex_id;
      const IntLanes shared = (other == id[0]) | (other == id[1]) | (other == id[2]);
      const bool share = laneBits(shared) != 0;
      adjacent_[adjacent] = pair;
      adjacent += share & wants_adjacent & (laneBits(shared & other) == 0);
      pairs[separate] = pair;
      separate += !share;
    }
  }
  return separate;
}

// Finds the pairs that no plane separates. They go to crossing_, or to open_ if a vertex may lie in
// a plane.
void PairFilter<Triangle>::dropByPlanes(const std::vector<Prepared>& triangles,
                                        const BoxPair* pairs, std::size_t count) {
  if (open_.size() < count) {
    open_.resize(count);
    crossing_.resize(count);
  }
  const std::size_t left = dropByRows(triangles.data(), pairs, count, margins_, open_.data());
  open_count_ = crossing_count_ = 0;
  dropByColumns(triangles.data(), left, margins_, decides_, open_.data(), open_count_,
                crossing_.data(), crossing_count_);
}

// Decides the pairs in crossing_, four at a time. Adds those that are still open to open_.
void PairFilter<Triangle>::decideCrossings(const std::vector<Prepared>& triangles,
                                           FilteredPairs<Triangle>& filtered) {
  for (std::size_t begin = 0; begin < crossing_count_; begin += 4) {
    const std::size_t count = std::min<std::size_t>(4, crossing_count_ - begin);
    CrossingPair four[4];
    for (std::size_t i = 0; i < 4; ++i) {
      const SidedPair& sided = crossing_[begin + std::min(i, count - 1)];
      four[i] = {&triangles[sided.pair.a.value].lanes, &triangles[sided.pair.b.value].lanes,
                 sided.a, sided.b};
    }
    const LaneCrossings crossings = crossingsOf(four);
    const int meet = laneBits(crossings.meet), apart = laneBits(crossings.apart);
    for (std::size_t i = 0; i < count; ++i) {
      const SidedPair& sided = crossing_[begin + i];
      if ((apart >> i & 1) != 0) {
        ++filtered.apart;
      } else if ((meet >> i & 1) != 0) {
        filtered.meeting.push_back(
            {triangles[sided.pair.a.value].triangle, triangles[sided.pair.b.value].triangle});
      } else {
        open_[open_count_++] = sided;
      }
    }
  }
}

void PairFilter<Triangle>::filter(const std::vector<Prepared>& triangles, BoxPair* pairs,
                                  std::size_t count, FilteredPairs<Triangle>& filtered) {
  std::size_t adjacent;
  const std::size_t separate = splitAdjacent(triangles, pairs, count, adjacent);
  dropByPlanes(triangles, pairs, separate);
  decideCrossings(triangles, filtered);
  for (std::size_t i = 0; i < open_count_; ++i) {
    const Prepared& a = triangles[open_[i].pair.a.value];
    const Prepared& b = triangles[open_[i].pair.b.value];
    const PartVerdict verdict =
        decides_ ? touchVerdict(input_.set.posed(a.triangle), input_.set.posed(b.triangle))
                 : PartVerdict::kOpen;
    if (verdict == PartVerdict::kApart) {
      ++filtered.apart;
    } else if (verdict == PartVerdict::kMeet) {
      filtered.meeting.push_back({a.triangle, b.triangle});
    } else {
      addCandidate(a, b, open_[i].a, open_[i].b, filtered.candidates);
    }
  }
  decideAdjacent(triangles, adjacent, filtered);
}

void PairFilter<Triangle>::filter(const Prepared& a, const Prepared& b,
                                  std::vector<Candidate<Triangle>>& candidates) const {
  if (sharedBits(a.vertex_id, b.vertex_id) != 0) {
    PairFacts facts;
    if (filterAdjacent(a, b, facts)) candidates.push_back({a.triangle, b.triangle, facts});
  } else {
    filterSeparate(a, b, candidates);
  }
}

// Adds a pair that shares no vertex, unless a plane separates it and there is no margin.
void PairFilter<Triangle>::addCandidate(const Prepared& a, const Prepared& b,
                                        const PlaneSides& sides_a, const PlaneSides& sides_b,
                                        std::vector<Candidate<Triangle>>& candidates) const {
  PairFacts facts;
  if (margins_) {
    facts.margin_m = pairMargin(input_.scene.body(a.body.value).margin_m,
                                input_.scene.body(b.body.value).margin_m);
  }
  if ((sides_a.allOnOne() || sides_b.allOnOne()) && facts.margin_m == 0) return;
  facts.sides = knownSides(sides_a, sides_b);
  candidates.push_back({a.triangle, b.triangle, facts});
}

// Filters one pair that shares no vertex.
void PairFilter<Triangle>::filterSeparate(const Prepared& a, const Prepared& b,
                                          std::vector<Candidate<Triangle>>& candidates) const {
  addCandidate(a, b, sidesOf(b.plane, a.lanes), sidesOf(a.plane, b.lanes), candidates);
}

// Returns whether two triangles that share vertices are a candidate, and fills in the facts that
// are known then.
bool PairFilter<Triangle>::filterAdjacent(const Prepared& a, const Prepared& b,
                                          PairFacts& facts) const {
  const int in_a = sharedBits(a.vertex_id, b.vertex_id);
  if (input_.options.adjacent == AdjacentPairs::kSkip || isCertified(a, in_a)) return false;
  const int in_b = sharedBits(b.vertex_id, a.vertex_id);
  const PlaneSides sides_a = sidesOf(b.plane, a.lanes);
  if (sides_a.othersOnOne(in_a)) return false;
  const PlaneSides sides_b = sidesOf(a.plane, b.lanes);
  if (sides_b.othersOnOne(in_b)) return false;
  facts.shared = sharedByBits(static_cast<std::uint32_t>(in_a), static_cast<std::uint32_t>(in_b));
  facts.sides = knownSides(sides_a, sides_b);
  return true;
}

// Decides the first `count` pairs in adjacent_, as far as the signs of the plane filters do.
void PairFilter<Triangle>::decideAdjacent(const std::vector<Prepared>& triangles, std::size_t count,
                                          FilteredPairs<Triangle>& filtered) const {
  for (std::size_t i = 0; i < count; ++i) {
    const Prepared& a = triangles[adjacent_[i].a.value];
    const Prepared& b = triangles[adjacent_[i].b.value];
    PairFacts facts;
    if (!filterAdjacent(a, b, facts)) continue;
    const PartVerdict verdict =
        decides_ ? beyondSharedVerdict(facts.shared, facts.sides) : PartVerdict::kOpen;
    if (verdict == PartVerdict::kApart) {
      ++filtered.apart;
    } else if (verdict == PartVerdict::kMeet) {
      filtered.meeting.push_back({a.triangle, b.triangle});
    } else {
      filtered.candidates.push_back({a.triangle, b.triangle, facts});
    }
  }
}

PairFilter<MovingTriangle>::PairFilter(const CycleInput<MovingTriangle>& input,
                                       FilterBuffers<MovingTriangle>& buffers)
    : input_(input),
      pads_(input.scene.anyPad()),
      lanes_(buffers.lanes),
      separate_(buffers.separate) {}

void PairFilter<MovingTriangle>::filter(
    const std::vector<PreparedTriangle<MovingTriangle>>& triangles, BoxPair* pairs,
    std::size_t count, FilteredPairs<MovingTriangle>& filtered) {
  std::vector<Candidate<MovingTriangle>>& candidates = filtered.candidates;
  // Only exact mode uses the vector filters: in conservative mode a pair that is left open counts
  // as contact, so that all pairs must get the same verdict.
  const bool exact = input_.options.predicates == Predicates::kExact;
  separate_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const BoxPair pair = pairs[i];
    const PreparedTriangle<MovingTriangle>&a = triangles[pair.a.value],
          &b = triangles[pair.b.value];
    if (!exact || padOf(a, b) > 0 || sharedBits(a.vertex_id, b.vertex_id) != 0) {
      filter(a, b, candidates);
    } else {
      pairs[separate_.size()] = pair;
      separate_.push_back({&a.posed, &b.posed});
    }
  }
  lanes_.filter(separate_, input_.options.first_times);
  const auto add = [&](std::uint32_t i, bool meet) {
    candidates.push_back({triangles[pairs[i].a.value].triangle,
                          triangles[pairs[i].b.value].triangle, SharedVertices(), meet});
  };
  for (const std::uint32_t i : lanes_.meeting()) add(i, true);
  for (const std::uint32_t i : lanes_.open()) add(i, false);
}

// Returns the motion bound of a pair [m]; 0 if no body has one.
float PairFilter<MovingTriangle>::padOf(const PreparedTriangle<MovingTriangle>& a,
                                        const PreparedTriangle<MovingTriangle>& b) const {
  if (!pads_) return 0;
  return pairPad(input_.scene.body(a.body.value).pad_m, input_.scene.body(b.body.value).pad_m);
}

void PairFilter<MovingTriangle>::filter(const PreparedTriangle<MovingTriangle>& a,
                                        const PreparedTriangle<MovingTriangle>& b,
                                        std::vector<Candidate<MovingTriangle>>& candidates) const {
  const int in_a = sharedBits(a.vertex_id, b.vertex_id);
  SharedVertices shared;
  if (in_a != 0) {
    if (input_.options.adjacent == AdjacentPairs::kSkip) return;
    const int in_b = sharedBits(b.vertex_id, a.vertex_id);
    shared = sharedByBits(static_cast<std::uint32_t>(in_a), static_cast<std::uint32_t>(in_b));
  }
  candidates.push_back({a.triangle, b.triangle, shared, false});
}

}  // namespace deformable_contact_monitor
