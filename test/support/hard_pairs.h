// Random pairs of triangles that touch, lie in one plane or are degenerate, by classes.
#pragma once

#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {

// Integers small enough that sums of a few products with small fractions are exact in float32.
class GridDice {
 public:
  explicit GridDice(unsigned seed) : random_(seed) {}
  int within(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  bool half() { return random_() % 2 == 0; }
  Vec3f point(int range) {
    return {static_cast<float>(within(-range, range)), static_cast<float>(within(-range, range)),
            static_cast<float>(within(-range, range))};
  }
  Triangle triangle(int range) { return {{point(range), point(range), point(range)}}; }
  // Returns a random multiple of 1/8 from low / 8 to high / 8.
  float eighths(int low, int high) { return static_cast<float>(within(low, high)) / 8; }

 private:
  std::mt19937 random_;
};

struct TrianglesPair {
  Triangle a, b;
};

struct HardPairClass {
  const char* name;
  TrianglesPair (*make)(GridDice*);
};

inline std::ostream& operator<<(std::ostream& out, const HardPairClass& pair_class) {
  return out << pair_class.name;
}

// About a third of each class touch.
std::vector<HardPairClass> hardPairClasses();

// All of it by a power of two.
TrianglesPair scaledBy(TrianglesPair pair, int power);

}  // namespace deformable_contact_monitor
