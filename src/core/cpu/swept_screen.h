// What most pairs of moving triangles end in: float32 filters over many pairs at once, in vector
// lanes. What they tell is certain, for any finite vertices; the rest is left open.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cpu/interval_scan.h"
#include "core/cpu/lane_motion.h"

namespace deformable_contact_monitor {

// Filters change no verdict; tests leave out one at a time.
enum SweptScreenFilters : unsigned {
  kScreenPlanes = 1,  // that move with one of the two
  kScreenEnds = 2,    // contact at either end of the step
  kScreenPieces = 4,  // directions, and contact, in ever smaller pieces of the step
  kAllScreenFilters = 7,
};

// For pairs that share no vertex. Keeps its buffers from call to call. One per thread.
class SweptScreen {
 public:
  explicit SweptScreen(unsigned filters = kAllScreenFilters) : filters_(filters) {}

  // Tells of pairs, positions in `triangles` with finite vertices, which may be apart at all times,
  // what meeting() and open() hold until the next call. With `wants_time` only contacts at the
  // start of the step are told.
  void screen(const std::vector<MovingTriangle>& triangles, const BoxPair* pairs, std::size_t count,
              bool wants_time);

  // Certainly in contact at some time; with `wants_time`, at the start.
  const std::vector<BoxPair>& meeting() const { return meeting_; }
  // Not decided. The others are certainly apart at all times.
  const std::vector<BoxPair>& open() const { return open_; }

 private:
  // Of a pair, a position in pairs_; its first half or second half may be all that is left.
  struct Piece {
    std::uint32_t pair;
    float low;
  };
  enum class Told : char { kApart, kMeet, kOpen };

  void dropApart();
  void findContacts(const std::vector<std::uint32_t>& pairs, bool at_end);
  void halveSteps(Told where_they_meet);
  void halvePieces(float width, Told where_they_meet);
  template <class PairOf>
  LanePairs gather(std::size_t begin, std::size_t end, const PairOf& pair_of) const;

  unsigned filters_;
  const std::vector<MovingTriangle>* triangles_ = nullptr;
  std::vector<BoxPair> pairs_;                    // that no plane parts
  std::vector<Told> told_;                        // of each of them
  std::vector<std::uint32_t> at_start_, at_end_;  // of them, those that may meet there
  std::vector<Piece> pieces_, halves_;
  std::vector<BoxPair> meeting_, open_;
};

}  // namespace deformable_contact_monitor
