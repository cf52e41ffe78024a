// The triangles of two tiles in a state, one pair of triangles at a time in the lanes of a warp.
#pragma once

#include "core/predicates/narrow_phase.h"
#include "cuda/states/state_boxes.cuh"

namespace deformable_contact_monitor {

// Corners of the triangles of two tiles in the scene frame, in shared memory of one warp, and the
// pairs of them that wait for a decision.
struct StateTilesRoom {
  static constexpr unsigned kQueue = 2 * kWarp;

  float corner[2][9][kWarp];
  std::uint16_t queue[kQueue];

  __device__ Triangle triangle(int side, unsigned i) const {
    const auto& c = corner[side];
    return {
        {{c[0][i], c[1][i], c[2][i]}, {c[3][i], c[4][i], c[5][i]}, {c[6][i], c[7][i], c[8][i]}}};
  }
};

// Looks at two tiles. All lanes of a warp call run(), with room of their own in shared memory.
class StateTilesSearch {
 public:
  __device__ StateTilesSearch(const StateArrays& s, StateTilesRoom* room) : s_(s), room_(*room) {}

  __device__ void run(const StateTiles& tiles) {
    bool is_idle = isAnswered(s_, tiles.state, tiles.pair);
    if (s_.question.nearest != 0) {
      is_idle = s_.tile_least[tiles.tile_a] >= firstIdle(s_, tiles.state, tiles.pair);
    }
    if (sameInWarp(is_idle ? 1 : 0) != 0) return;
    tiles_ = tiles;
    pair_ = s_.pairs[tiles.pair];
    reach_m_ = sameInWarp(reachOf(s_, pair_, tiles.state));
    __syncwarp();  // all lanes have done with what the room held
    const bool live_a = place(0, pair_.a, tiles.tile_a);
    const bool live_b = place(1, pair_.b, tiles.tile_b);
    __syncwarp();
    const Aabb box_a = live_a ? boxOf(room_.triangle(0, laneId())) : Aabb();
    const Aabb box_b = live_b ? boxOf(room_.triangle(1, laneId())) : Aabb();
    bool near_a = areInReach(box_a, warpBox(box_b), reach_m_);
    if (s_.question.nearest != 0) {
      const std::uint32_t idle = firstIdle(s_, tiles.state, tiles.pair);
      near_a = near_a && s_.slot_triangle[tiles.tile_a * kWarp + laneId()] < idle;
    }
    const bool near_b = areInReach(box_b, warpBox(box_a), reach_m_);
    std::uint32_t part_a = 0, part_b = 0;
    if (s_.slot_part != nullptr) {
      part_a = s_.slot_part[tiles.tile_a * kWarp + laneId()];
      part_b = s_.slot_part[tiles.tile_b * kWarp + laneId()];
    }
    queued_ = 0;
    unsigned left = __ballot_sync(kFullWarp, near_b);
    for (; left != 0; left &= left - 1) {
      const int j = __ffs(static_cast<int>(left)) - 1;
      const Aabb box{laneVector(box_b.min, j), laneVector(box_b.max, j)};
      bool wanted = near_a && areInReach(box_a, box, reach_m_);
      if (s_.slot_part != nullptr) {
        const std::uint32_t part = __shfl_sync(kFullWarp, part_b, j);
        wanted = wanted && s_.parts.enabled(part_a, part);
      }
      add(wanted, j);
      if (queued_ >= kWarp && decide(kWarp)) return;
    }
    if (queued_ > 0) decide(queued_);
  }

 private:
  // Poses this lane's triangle of a tile. Returns whether all of its vertices are finite.
  __device__ bool place(int side, std::uint32_t body, std::uint32_t tile) {
    const std::uint32_t slot = tile * kWarp + laneId();
    const Triangle t = posedSlot(s_, tiles_.state, body, slot);
    for (int k = 0; k < 3; ++k) {
      room_.corner[side][3 * k][laneId()] = t.v[k].x;
      room_.corner[side][3 * k + 1][laneId()] = t.v[k].y;
      room_.corner[side][3 * k + 2][laneId()] = t.v[k].z;
    }
    return (s_.live[tile] >> laneId() & 1) != 0 && isFinite(t);
  }

  // Queues this lane's triangle of a with triangle j of b.
  __device__ void add(bool wanted, int j) {
    const unsigned mask = __ballot_sync(kFullWarp, wanted);
    if (wanted) {
      const unsigned place = queued_ + __popc(mask & ((1U << laneId()) - 1));
      room_.queue[place] = static_cast<std::uint16_t>(laneId() << 8 | static_cast<unsigned>(j));
    }
    queued_ += __popc(mask);
    __syncwarp();
  }

  // Decides the last `count` <= kWarp queued pairs. Returns whether these bodies need no further
  // look.
  __device__ bool decide(unsigned count) {
    queued_ -= count;
    if (s_.question.nearest == 0) {
      const bool touches = laneId() < count && touch(queued_ + laneId());
      const bool any = __any_sync(kFullWarp, touches) != 0;
      if (any && laneId() == 0) noteTouch();
      __syncwarp();  // the queue may be written from here on
      return any;
    }
    const bool open = laneId() < count && mayBeNearest(queued_ + laneId());
    unsigned left = __ballot_sync(kFullWarp, open);
    constexpr int kFew = 12;  // Up to so many, half a warp measures each; else each lane does one.
    if (__popc(left) > kFew) {
      if (open) {
        const Triangle a = queuedA(queued_ + laneId()), b = queuedB(queued_ + laneId());
        take(queued_ + laneId(), meet(a, b) ? 0 : comparedDistance(separation(a, b)));
      }
      left = 0;
    }
    while (left != 0) {
      const unsigned first = __ffs(static_cast<int>(left)) - 1;
      left &= left - 1;
      const bool has_second = left != 0;
      const unsigned second = has_second ? __ffs(static_cast<int>(left)) - 1 : first;
      left &= left - 1;
      const bool is_second = laneId() >= kLanesEach;
      const unsigned place = queued_ + (is_second ? second : first);
      const bool counts = !is_second || has_second;
      const float bare_m = distanceBetween(queuedA(place), queuedB(place), counts);
      if (counts && laneId() % kLanesEach == 0) take(place, bare_m);
    }
    __syncwarp();
    reach_m_ = sameInWarp(reachOf(s_, pair_, tiles_.state));
    return false;
  }

  __device__ Triangle queuedA(unsigned place) const {
    return room_.triangle(0, room_.queue[place] >> 8);
  }
  __device__ Triangle queuedB(unsigned place) const {
    return room_.triangle(1, room_.queue[place] & 0xffU);
  }

  // Returns whether two queued triangles touch, with their radii.
  __device__ bool touch(unsigned place) const {
    const Triangle a = queuedA(place), b = queuedB(place);
    PairFacts facts;
    facts.margin_m = pair_.touch_m;
    if (!isCandidate(a, b, facts)) return false;
    PredicateState state;
    if (trianglesIntersect(a, b, facts.sides, state)) return true;
    return pair_.touch_m > 0 && !arePlanesApart(a, b, reach_m_) &&
           comparedDistance(separation(a, b)) <= pair_.touch_m;
  }

  __device__ void noteTouch() {
    const std::size_t place = std::size_t{tiles_.state} * s_.pair_count + tiles_.pair;
    s_.pair_touches[place] = 1;
    s_.touches[tiles_.state] = 1;
  }

  // Returns whether queued triangles may be as near as the nearest ones so far.
  __device__ bool mayBeNearest(unsigned place) const {
    const Triangle a = queuedA(place), b = queuedB(place);
    return areInReach(boxOf(a), boxOf(b), reach_m_) && !arePlanesApart(a, b, reach_m_);
  }

  // Notes the bare distance of queued triangles, if no others are nearer.
  __device__ void take(unsigned place, float bare_m) {
    const std::uint32_t slot_a = tiles_.tile_a * kWarp + (room_.queue[place] >> 8);
    const std::uint32_t slot_b = tiles_.tile_b * kWarp + (room_.queue[place] & 0xffU);
    const float apart_m = pair_.apartM(bare_m);
    float margin_m = pair_.margin_m;
    if (s_.slot_margin != nullptr) margin_m = fmaxf(s_.slot_margin[slot_a], s_.slot_margin[slot_b]);
    if (!(apart_m <= margin_m)) return;
    if (apart_m == 0) {
      noteTouch();
      const std::uint32_t triangle_a = s_.slot_triangle[slot_a];
      if (triangle_a >= firstIdle(s_, tiles_.state, tiles_.pair)) return;
      if (pair_.touch_m == 0) {
        atomicMin(&s_.first_touch[tiles_.state], Key{tiles_.pair} << 32 | triangle_a);
      }
    }
    if (__float_as_uint(apart_m) > atomicMin(&s_.apart[tiles_.state], __float_as_uint(apart_m))) {
      return;
    }
    const std::uint32_t hit = reserve(&s_.counters->hits, 1);
    if (hit < s_.hits_size) {
      s_.hits[hit] = {tiles_.state, tiles_.pair, slot_a, slot_b, apart_m, bare_m};
    }
  }

  const StateArrays& s_;
  StateTilesRoom& room_;
  StateTiles tiles_{};
  DeviceStatePair pair_{};
  float reach_m_ = 0;
  unsigned queued_ = 0;
};

}  // namespace deformable_contact_monitor
