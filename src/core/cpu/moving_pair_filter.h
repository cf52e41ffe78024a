// Float32 filters over many pairs of moving triangles, four pairs at a time. They decide most pairs
// whose moving boxes meet.
//
// 1. Planes that move with a triangle: a pair whose vertices stay on one side is apart. 2. Contact
// at either end of the time interval, for pairs that cross each other's planes there. 3. Pieces of
// the interval, at first all of it: twelve directions of its middle may show that a half is apart,
// or that there is a contact. What is left after seven halvings is open. Every answer is certain
// for finite vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cpu/moving_lanes.h"

namespace deformable_contact_monitor {

// The filters as bits. They change no verdict; tests leave out one at a time.
enum MovingPairFilterParts : unsigned {
  kFilterPlanes = 1,  // that move with one of the two triangles
  kFilterEnds = 2,    // contact at either end of the time interval
  kFilterPieces = 4,  // directions, and contact, in ever smaller pieces of the interval
  kAllMovingFilters = 7,
};

// Two triangles with finite vertices that share no vertex.
struct MovingTriangles {
  const MovingTriangle *a, *b;
};

// Filters pairs of moving triangles. It keeps its buffers from call to call. There is one per
// thread.
class MovingPairFilter {
 public:
  explicit MovingPairFilter(unsigned filters = kAllMovingFilters) : filters_(filters) {}

  // Filters the pairs; meeting() and open() hold the results until the next call. If `wants_time`,
  // only contacts at the start are reported as meeting, otherwise contacts at any time.
  void filter(const std::vector<MovingTriangles>& pairs, bool wants_time);

  // Positions in `pairs`, ascending, of the pairs that are certainly in contact.
  const std::vector<std::uint32_t>& meeting() const { return meeting_; }
  // Positions in `pairs`, ascending, of the pairs that are not decided. All others are certainly
  // apart during the whole interval.
  const std::vector<std::uint32_t>& open() const { return open_; }

 private:
  struct Piece {  // of the time interval of a pair
    std::uint32_t pair;
    float low;
  };
  enum class Outcome : char { kApart, kMeet, kOpen };

  void dropApart();
  void findContacts(const std::vector<std::uint32_t>& pairs, bool at_end);
  void halveSteps(Outcome if_meeting);
  void halvePieces(float width, Outcome if_meeting);
  void keepPieces();
  template <class PairOf>
  LanePairs gather(std::size_t begin, std::size_t end, const PairOf& pair_of) const;

  unsigned filters_;
  const MovingTriangles* pairs_ = nullptr;
  std::vector<Outcome> outcome_;                         // of each pair
  std::vector<std::uint32_t> left_, at_start_, at_end_;  // that no plane parts; that may meet there
  std::vector<Piece> pieces_, halves_;
  std::vector<std::uint32_t> meeting_, open_;
};

}  // namespace deformable_contact_monitor
