#include "core/cpu/moving_pair_filter.h"

#include <algorithm>

namespace deformable_contact_monitor {

// Gathers the pairs pair_of(begin) ... into lanes, up to `end`. The last pair fills the lanes
// beyond.
template <class PairOf>
LanePairs MovingPairFilter::gather(std::size_t begin, std::size_t end,
                                   const PairOf& pair_of) const {
  const MovingTriangle *a[kLanes], *b[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i) {
    const MovingTriangles& pair = pairs_[pair_of(std::min(begin + i, end - 1))];
    a[i] = pair.a;
    b[i] = pair.b;
  }
  return LanePairs(a, b);
}

// Lists the pairs that no plane separates (left_), and of them those that may meet at the start
// (at_start_) or at the end (at_end_).
void MovingPairFilter::dropApart() {
  const std::size_t count = outcome_.size();
  for (auto* list : {&left_, &at_start_, &at_end_}) list->resize(count);
  std::size_t left = 0, starts = 0, ends = 0;
  for (std::size_t begin = 0; begin < count; begin += kLanes) {
    const LanePairs t = gather(begin, count, [](std::size_t i) { return i; });
    const LaneSides of_b(t.from.a, t.to.a, t.from.b, t.to.b);
    const LaneSides of_a(t.from.b, t.to.b, t.from.a, t.to.a);
    const int apart = (filters_ & kFilterPlanes) != 0 ? laneBits(of_b.apart | of_a.apart) : 0;
    const int start = laneBits(of_b.on_both_at_start & of_a.on_both_at_start);
    const int end = laneBits(of_b.on_both_at_end & of_a.on_both_at_end);
    for (std::size_t i = 0; i < std::min(kLanes, count - begin); ++i) {
      left_[left] = at_start_[starts] = at_end_[ends] = static_cast<std::uint32_t>(begin + i);
      left += (apart >> i & 1) == 0;
      starts += (start >> i & 1) != 0;
      ends += (end >> i & 1) != 0;
    }
  }
  left_.resize(left);
  at_start_.resize(starts);
  at_end_.resize(ends);
}

// Finds the pairs that certainly meet at one end of the interval.
void MovingPairFilter::findContacts(const std::vector<std::uint32_t>& pairs, bool at_end) {
  const FloatLanes time = FloatLanes{} + (at_end ? 1.0F : 0.0F);
  for (std::size_t begin = 0; begin < pairs.size(); begin += kLanes) {
    const LaneMotion motion(
        gather(begin, pairs.size(), [&pairs](std::size_t i) { return pairs[i]; }));
    const int meet = laneBits(motion.meet(time));
    for (std::size_t i = 0; i < std::min(kLanes, pairs.size() - begin); ++i) {
      if ((meet >> i & 1) != 0) outcome_[pairs[begin + i]] = Outcome::kMeet;
    }
  }
}

// Lists the halves of pieces_ that are not certainly apart.
void MovingPairFilter::halvePieces(float width, Outcome if_meeting) {
  halves_.resize(2 * pieces_.size());
  std::size_t halves = 0;
  for (std::size_t begin = 0; begin < pieces_.size(); begin += kLanes) {
    const LaneMotion motion(
        gather(begin, pieces_.size(), [this](std::size_t i) { return pieces_[i].pair; }));
    const std::size_t lanes = std::min(kLanes, pieces_.size() - begin);
    FloatLanes low{};
    for (std::size_t i = 0; i < lanes; ++i) low[i] = pieces_[begin + i].low;
    const LanePiece piece = motion.piece(low, width);
    const int meet = laneBits(piece.meet);
    const int first = laneBits(piece.apart_in_first), second = laneBits(piece.apart_in_second);
    for (std::size_t i = 0; i < lanes; ++i) {
      const Piece whole = pieces_[begin + i];
      if ((meet >> i & 1) != 0) outcome_[whole.pair] = if_meeting;
      halves_[halves] = whole;
      halves += (first >> i & 1) == 0;
      halves_[halves] = {whole.pair, whole.low + width / 2};
      halves += (second >> i & 1) == 0;
    }
  }
  halves_.resize(halves);
}

// Turns halves_, in which those of a pair follow each other, into the next pieces_. Pairs with too
// many pieces become open: where most of them stay, as in one plane, these filters decide nothing.
void MovingPairFilter::keepPieces() {
  constexpr std::size_t kMostPieces = 4;
  pieces_.clear();
  std::size_t of_pair = 0;
  for (std::size_t i = 0; i < halves_.size(); ++i) {
    const std::uint32_t pair = halves_[i].pair;
    of_pair = i > 0 && halves_[i - 1].pair == pair ? of_pair + 1 : 1;
    if (outcome_[pair] != Outcome::kApart) continue;
    pieces_.push_back(halves_[i]);
    if (of_pair <= kMostPieces) continue;
    pieces_.resize(pieces_.size() - of_pair);
    outcome_[pair] = Outcome::kOpen;
  }
}

// Halves the time interval of the pairs that are not decided, again and again.
void MovingPairFilter::halveSteps(Outcome if_meeting) {
  pieces_.clear();
  for (const std::uint32_t pair : left_) {
    if (outcome_[pair] == Outcome::kApart) pieces_.push_back({pair, 0});
  }
  constexpr int kHalvings =
      7;  // few pairs are open by then, and more halvings would decide few of them
  float width = 1;
  for (int i = 0; i < kHalvings && (filters_ & kFilterPieces) != 0; ++i, width /= 2) {
    halvePieces(width, if_meeting);
    keepPieces();
  }
  for (const Piece& piece : pieces_) outcome_[piece.pair] = Outcome::kOpen;
}

// Runs the filters in order. A pair starts as apart, and each filter may change that.
void MovingPairFilter::filter(const std::vector<MovingTriangles>& pairs, bool wants_time) {
  pairs_ = pairs.data();
  outcome_.assign(pairs.size(), Outcome::kApart);
  dropApart();
  if ((filters_ & kFilterEnds) != 0) {
    findContacts(at_start_, false);
    if (!wants_time) findContacts(at_end_, true);
  }
  halveSteps(wants_time ? Outcome::kOpen : Outcome::kMeet);
  meeting_.clear();
  open_.clear();
  for (const std::uint32_t pair : left_) {
    if (outcome_[pair] == Outcome::kMeet) meeting_.push_back(pair);
    if (outcome_[pair] == Outcome::kOpen) open_.push_back(pair);
  }
}

}  // namespace deformable_contact_monitor
