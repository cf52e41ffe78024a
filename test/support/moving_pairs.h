// Seeded random pairs of moving triangles, by classes: where floating point alone would guess.
#pragma once

#include <ostream>
#include <random>
#include <vector>

#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

struct MovingPair {
  MovingTriangle a, b;
};

// The same seed gives the same throws on every machine.
class MotionDice {
 public:
  explicit MotionDice(unsigned seed) : random_(seed) {}
  int within(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  bool half() { return random_() % 2 == 0; }
  Vec3f point(int range);
  Triangle triangle(int range);
  MovingTriangle moving(int range) { return {triangle(range), triangle(range)}; }
  MovingPair pair(int range) { return {moving(range), moving(range)}; }

 private:
  std::mt19937 random_;
};

struct MovingPairClass {
  const char* name;
  MovingPair (*make)(MotionDice* dice);
};

inline std::ostream& operator<<(std::ostream& out, const MovingPairClass& pairs) {
  return out << pairs.name;
}

// Pairs that share no vertex, or share some by chance.
const std::vector<MovingPairClass>& movingPairClasses();

// Pairs that share one or two trajectories.
const std::vector<MovingPairClass>& sharingPairClasses();

// All coordinates times 2^power.
MovingPair scaled(const MovingPair& pair, int power);

inline MovingTriangle reversed(const MovingTriangle& t) { return {t.to, t.from}; }

}  // namespace deformable_contact_monitor
