#include "core/cpu/swept_screen.h"

#include <algorithm>

#include "core/cpu/lane_filters.h"

namespace deformable_contact_monitor {

// Those that pair_of tells for positions in [begin, end), the last one also in lanes beyond.
template <class PairOf>
LanePairs SweptScreen::gather(std::size_t begin, std::size_t end, const PairOf& pair_of) const {
  const MovingTriangle *a[kLanes], *b[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i) {
    const BoxPair& pair = pairs_[pair_of(std::min(begin + i, end - 1))];
    a[i] = &(*triangles_)[pair.a.value];
    b[i] = &(*triangles_)[pair.b.value];
  }
  return LanePairs(a, b);
}

// Keeps those that no plane parts, and lists those that may meet at either end.
void SweptScreen::dropApart() {
  const std::size_t count = pairs_.size();
  at_start_.resize(count);
  at_end_.resize(count);
  std::size_t kept = 0, starts = 0, ends = 0;
  for (std::size_t begin = 0; begin < count; begin += kLanes) {
    const LanePairs t = gather(begin, count, [](std::size_t i) { return i; });
    const LaneSides of_b(t.from.a, t.to.a, t.from.b, t.to.b);
    const LaneSides of_a(t.from.b, t.to.b, t.from.a, t.to.a);
    const int apart = (filters_ & kScreenPlanes) != 0 ? laneBits(of_b.apart | of_a.apart) : 0;
    const int start = laneBits(of_b.on_both_at_start & of_a.on_both_at_start);
    const int end = laneBits(of_b.on_both_at_end & of_a.on_both_at_end);
    for (std::size_t i = 0; i < std::min(kLanes, count - begin); ++i) {
      const bool keep = (apart >> i & 1) == 0;
      pairs_[kept] = pairs_[begin + i];
      at_start_[starts] = at_end_[ends] = static_cast<std::uint32_t>(kept);
      kept += keep;
      starts += keep & ((start >> i & 1) != 0);
      ends += keep & ((end >> i & 1) != 0);
    }
  }
  pairs_.resize(kept);
  at_start_.resize(starts);
  at_end_.resize(ends);
}

void SweptScreen::findContacts(const std::vector<std::uint32_t>& pairs, bool at_end) {
  const FloatLanes time = FloatLanes{} + (at_end ? 1.0F : 0.0F);
  for (std::size_t begin = 0; begin < pairs.size(); begin += kLanes) {
    const LaneMotion motion(
        gather(begin, pairs.size(), [&pairs](std::size_t i) { return pairs[i]; }));
    const int meet = laneBits(motion.meet(time));
    for (std::size_t i = 0; i < std::min(kLanes, pairs.size() - begin); ++i) {
      if ((meet >> i & 1) != 0) told_[pairs[begin + i]] = Told::kMeet;
    }
  }
}

// Of pieces_, makes the halves that are not certainly apart.
void SweptScreen::halvePieces(float width, Told where_they_meet) {
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
      const std::uint32_t pair = pieces_[begin + i].pair;
      if ((meet >> i & 1) != 0) told_[pair] = where_they_meet;
      halves_[halves] = pieces_[begin + i];
      halves += (first >> i & 1) == 0;
      halves_[halves] = {pair, pieces_[begin + i].low + width / 2};
      halves += (second >> i & 1) == 0;
    }
  }
  halves_.resize(halves);
}

void SweptScreen::halveSteps(Told where_they_meet) {
  pieces_.clear();
  for (std::uint32_t i = 0; i < pairs_.size(); ++i) {
    if (told_[i] == Told::kApart) pieces_.push_back({i, 0});
  }
  constexpr int kHalvings = 7;  // one more costs what the verdicts on what it settles do
  float width = 1;
  for (int i = 0; i < kHalvings && (filters_ & kScreenPieces) != 0; ++i, width /= 2) {
    halvePieces(width, where_they_meet);
    pieces_.clear();
    for (const Piece& half : halves_) {
      if (told_[half.pair] == Told::kApart) pieces_.push_back(half);
    }
  }
  for (const Piece& piece : pieces_) told_[piece.pair] = Told::kOpen;
}

void SweptScreen::screen(const std::vector<MovingTriangle>& triangles, const BoxPair* pairs,
                         std::size_t count, bool wants_time) {
  triangles_ = &triangles;
  pairs_.assign(pairs, pairs + count);
  dropApart();
  told_.assign(pairs_.size(), Told::kApart);
  if ((filters_ & kScreenEnds) != 0) {
    findContacts(at_start_, false);
    if (!wants_time) findContacts(at_end_, true);
  }
  halveSteps(wants_time ? Told::kOpen : Told::kMeet);
  meeting_.clear();
  open_.clear();
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (told_[i] == Told::kMeet) meeting_.push_back(pairs_[i]);
    if (told_[i] == Told::kOpen) open_.push_back(pairs_[i]);
  }
}

}  // namespace deformable_contact_monitor
