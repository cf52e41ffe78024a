#include "core/cpu/filter.h"

#include <algorithm>

#include "core/cpu/lane_crossing.h"
#include "core/cpu/wide_clones.h"
#include "core/predicates/vertex_fan.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

using Prepared = PreparedTriangle<Triangle>;
using SidedPair = ScreenBuffers<Triangle>::SidedPair;

// Whether one of these vertices has a certified fan: then triangles that share it meet in what they
// share alone.
bool isCertified(const Prepared& a, int shared_bits) {
  static_assert(kFanCertified == std::uint32_t{1} << 31, "the sign");
  return (laneBits(a.vertex_id < 0) & shared_bits) != 0;
}

KnownSides knownSides(const PlaneSides& sides_a, const PlaneSides& sides_b) {
  KnownSides sides;
  for (int i = 0; i < 3; ++i) {
    sides.a[i] = sides_a.of(i);
    sides.b[i] = sides_b.of(i);
  }
  return sides;
}

// Fills `left` with the pairs that the rows' planes do not part, or with all; how many. A row's
// plane stays in registers.
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

// Of `open`, those that the columns' planes do not part, or all: where `settles`, to `crossing` if
// no vertex may lie in a plane; the others are the first of `open` then.
DCM_WIDE_CLONES void dropByColumns(const Prepared* triangles, std::size_t count, bool all,
                                   bool settles, SidedPair* open, std::size_t& open_count,
                                   SidedPair* crossing, std::size_t& crossing_count) {
  std::size_t opens = 0, crossings = 0;
  for (std::size_t i = 0; i < count; ++i) {
    SidedPair sided = open[i];
    sided.a = sidesOf(triangles[sided.pair.b.value].plane, triangles[sided.pair.a.value].lanes);
    const bool strict = sided.a.allStrict() & sided.b.allStrict() & settles;
    const bool keep = !sided.a.allOnOne() | all;
    open[opens] = crossing[crossings] = sided;
    opens += keep & !strict;
    crossings += keep & strict;
  }
  open_count = opens;
  crossing_count = crossings;
}

}  // namespace

// In other modes what is open counts, so that all must be asked alike.
PairScreen<Triangle>::PairScreen(const CycleInput<Triangle>& input,
                                 ScreenBuffers<Triangle>& buffers)
    : input_(input),
      margins_(input.scene.anyMargin()),
      settles_(!margins_ && input.options.predicates == Predicates::kExact),
      neighbours_(buffers.neighbours),
      open_(buffers.open),
      crossing_(buffers.crossing) {}

// The pairs that share a vertex and may meet beyond it to neighbours_; how many share none: they
// are the first of `pairs` then.
std::size_t PairScreen<Triangle>::splitOff(const std::vector<Prepared>& triangles, BoxPair* pairs,
                                           std::size_t count, std::size_t& neighbours) {
  if (neighbours_.size() < count) neighbours_.resize(count);
  const bool wants_neighbours = input_.options.adjacent == AdjacentPairs::kBeyondShared;
  std::size_t separate = 0;
  neighbours = 0;
  for (std::size_t i = 0; i < count;) {
    const SortedIndex row = pairs[i].a;
    const IntLanes id = triangles[row.value].vertex_id;
    for (; i < count && pairs[i].a == row; ++i) {
      const BoxPair pair = pairs[i];
      const IntLanes& other = triangles[pair.b.value].vertex_id;
      const IntLanes shared = (other == id[0]) | (other == id[1]) | (other == id[2]);
      const bool share = laneBits(shared) != 0;
      neighbours_[neighbours] = pair;
      neighbours += share & wants_neighbours & (laneBits(shared & other) == 0);
      pairs[separate] = pair;
      separate += !share;
    }
  }
  return separate;
}

// Those that no plane parts: to crossing_, or, where a vertex may lie in a plane, to open_.
void PairScreen<Triangle>::dropAside(const std::vector<Prepared>& triangles, const BoxPair* pairs,
                                     std::size_t count) {
  if (open_.size() < count) {
    open_.resize(count);
    crossing_.resize(count);
  }
  const std::size_t left = dropByRows(triangles.data(), pairs, count, margins_, open_.data());
  open_count_ = crossing_count_ = 0;
  dropByColumns(triangles.data(), left, margins_, settles_, open_.data(), open_count_,
                crossing_.data(), crossing_count_);
}

// Of crossing_, four at a time; adds to open_ what is open.
void PairScreen<Triangle>::settleCrossings(const std::vector<Prepared>& triangles,
                                           Screened<Triangle>& screened) {
  for (std::size_t begin = 0; begin < crossing_count_; begin += 4) {
    const std::size_t count = std::min<std::size_t>(4, crossing_count_ - begin);
    CrossingPair four[4];
    for (std::size_t i = 0; i < 4; ++i) {
      const SidedPair& sided = crossing_[begin + std::min(i, count - 1)];
      four[i] = {&triangles[sided.pair.a.value].lanes, &triangles[sided.pair.b.value].lanes,
                 sided.a, sided.b};
    }
    const LaneCrossings told = crossingsOf(four);
    const int meet = laneBits(told.meet), apart = laneBits(told.apart);
    for (std::size_t i = 0; i < count; ++i) {
      const SidedPair& sided = crossing_[begin + i];
      if ((apart >> i & 1) != 0) {
        ++screened.apart;
      } else if ((meet >> i & 1) != 0) {
        screened.meeting.push_back(
            {triangles[sided.pair.a.value].triangle, triangles[sided.pair.b.value].triangle});
      } else {
        open_[open_count_++] = sided;
      }
    }
  }
}

void PairScreen<Triangle>::screen(const std::vector<Prepared>& triangles, BoxPair* pairs,
                                  std::size_t count, Screened<Triangle>& screened) {
  std::size_t neighbours;
  const std::size_t separate = splitOff(triangles, pairs, count, neighbours);
  dropAside(triangles, pairs, separate);
  settleCrossings(triangles, screened);
  for (std::size_t i = 0; i < open_count_; ++i) {
    const Prepared& a = triangles[open_[i].pair.a.value];
    const Prepared& b = triangles[open_[i].pair.b.value];
    if (settles_ &&
        certainlyApartInProjection(input_.set.posed(a.triangle), input_.set.posed(b.triangle))) {
      ++screened.apart;
    } else {
      addCandidate(a, b, open_[i].a, open_[i].b, screened.candidates);
    }
  }
  settleNeighbours(triangles, neighbours, screened);
}

void PairScreen<Triangle>::screen(const Prepared& a, const Prepared& b,
                                  std::vector<Candidate<Triangle>>& candidates) const {
  if (sharedBits(a.vertex_id, b.vertex_id) != 0) {
    PairFacts facts;
    if (screenNeighbours(a, b, facts)) candidates.push_back({a.triangle, b.triangle, facts});
  } else {
    screenSeparate(a, b, candidates);
  }
}

// Two that share nothing and no plane parts, or that are near one another.
void PairScreen<Triangle>::addCandidate(const Prepared& a, const Prepared& b,
                                        const PlaneSides& sides_a, const PlaneSides& sides_b,
                                        std::vector<Candidate<Triangle>>& candidates) const {
  PairFacts facts;
  facts.margin_m = pairMargin(input_.scene.body(a.body.value).margin_m,
                              input_.scene.body(b.body.value).margin_m);
  if ((sides_a.allOnOne() || sides_b.allOnOne()) && facts.margin_m == 0) return;
  facts.sides = knownSides(sides_a, sides_b);
  candidates.push_back({a.triangle, b.triangle, facts});
}

void PairScreen<Triangle>::screenSeparate(const Prepared& a, const Prepared& b,
                                          std::vector<Candidate<Triangle>>& candidates) const {
  addCandidate(a, b, sidesOf(b.plane, a.lanes), sidesOf(a.plane, b.lanes), candidates);
}

// Whether two that share vertices are a candidate.
bool PairScreen<Triangle>::screenNeighbours(const Prepared& a, const Prepared& b,
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

// Those of neighbours_, up to `count`, that are contacts or candidates.
void PairScreen<Triangle>::settleNeighbours(const std::vector<Prepared>& triangles,
                                            std::size_t count, Screened<Triangle>& screened) const {
  for (std::size_t i = 0; i < count; ++i) {
    const Prepared& a = triangles[neighbours_[i].a.value];
    const Prepared& b = triangles[neighbours_[i].b.value];
    PairFacts facts;
    if (!screenNeighbours(a, b, facts)) continue;
    const PartVerdict verdict =
        settles_ ? beyondSharedVerdict(facts.shared, facts.sides) : PartVerdict::kOpen;
    if (verdict == PartVerdict::kApart) {
      ++screened.apart;
    } else if (verdict == PartVerdict::kMeet) {
      screened.meeting.push_back({a.triangle, b.triangle});
    } else {
      screened.candidates.push_back({a.triangle, b.triangle, facts});
    }
  }
}

}  // namespace deformable_contact_monitor
