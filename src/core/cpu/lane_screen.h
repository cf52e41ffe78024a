// What most pairs of moving triangles end in: float32 filters over many pairs at once, in vector
// lanes. What they tell is certain, for any finite vertices; the rest is left open.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cpu/lane_motion.h"

namespace deformable_contact_monitor {

// Filters change no verdict; tests leave out one at a time.
enum LaneScreenFilters : unsigned {
  kScreenPlanes = 1,  // that move with one of the two
  kScreenEnds = 2,    // contact at either end of the step
  kScreenPieces = 4,  // directions, and contact, in ever smaller pieces of the step
  kAllScreenFilters = 7,
};

// Two triangles with finite vertices that share none.
struct MovingTriangles {
  const MovingTriangle *a, *b;
};

// Keeps its buffers from call to call. One per thread.
class LaneScreen {
 public:
  explicit LaneScreen(unsigned filters = kAllScreenFilters) : filters_(filters) {}

  // Sets what meeting() and open() hold until the next call. With `wants_time` only contacts at the
  // start of the step are told, else at any time.
  void screen(const std::vector<MovingTriangles>& pairs, bool wants_time);

  // Positions in `pairs`, ascending, of those that are certainly in contact,
  const std::vector<std::uint32_t>& meeting() const { return meeting_; }
  // and of those that are not decided. The others are certainly apart at all times.
  const std::vector<std::uint32_t>& open() const { return open_; }

 private:
  struct Piece {  // of the step
    std::uint32_t pair;
    float low;
  };
  enum class Told : char { kApart, kMeet, kOpen };

  void dropApart();
  void findContacts(const std::vector<std::uint32_t>& pairs, bool at_end);
  void halveSteps(Told where_they_meet);
  void halvePieces(float width, Told where_they_meet);
  void keepPieces();
  template <class PairOf>
  LanePairs gather(std::size_t begin, std::size_t end, const PairOf& pair_of) const;

  unsigned filters_;
  const MovingTriangles* pairs_ = nullptr;
  std::vector<Told> told_;                               // of each pair
  std::vector<std::uint32_t> left_, at_start_, at_end_;  // that no plane parts; that may meet there
  std::vector<Piece> pieces_, halves_;
  std::vector<std::uint32_t> meeting_, open_;
};

}  // namespace deformable_contact_monitor
