// Random pairs of triangles for tests of their geometry, and what is measured on them.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/pair_geometry.h"
#include "core/predicates/triangle.h"
#include "hard_pairs.h"

namespace deformable_contact_monitor {

// Coordinates anywhere within `size` of 0.
float real(GridDice* dice, float size);
Vec3f realPoint(GridDice* dice, float size);
Triangle realTriangle(GridDice* dice, float size);

bool meet(const TrianglesPair& pair);

// The largest coordinate.
double sizeOf(const Triangle& t);
double longestEdge(const Triangle& t);
// Returns the vector from vertex i to the next one.
Vec3d edgeOf(const Triangle& t, int i);

// The stated error of a point of a contact [m].
double pointError(const Vec3f& p);

float lengthOf(const Vec3f& v);
double lengthOf(const Vec3d& v);

std::string describe(const TrianglesPair& pair);
std::string describe(const PairGeometry& g);

// On hard pairs by classes, general ones, nearly parallel ones, slivers, far vertices, and whatever
// floats there are. $DCM_FUZZ_PAIRS says how many of each class.
class PairClassSuite : public testing::TestWithParam<HardPairClass> {
 protected:
  // Calls check(pair) for many pairs of the class; with a larger share, for fewer.
  void forPairs(long share, const std::function<void(const TrianglesPair&)>& check);
};

std::vector<HardPairClass> geometryPairClasses();

inline std::string pairClassName(const testing::TestParamInfo<HardPairClass>& info) {
  return info.param.name;
}

}  // namespace deformable_contact_monitor
