// Tests that roundings to float32 happen where the result becomes a double again.
#include <gtest/gtest.h>

#include "rounded_lines.h"

namespace deformable_contact_monitor {
namespace {

// No compiler may leave out what it does with a volatile variable.
double rounded(double x) {
  volatile float stored = static_cast<float>(x);
  return stored;
}

TEST(Float32Rounding, HappensWithTheFlagsOfTheProjectAndWithTheFunction) {
  const double a[3] = {0.1, 1.0 / 3 + 1e-9, -7e10 / 9};
  for (const double x : a) ASSERT_NE(3 * x, rounded(3 * x));
  double flags[2], function[2], vector[3];
  roundTwo(a, flags);
  roundTwoByFunction(a, function);
  roundVector(a, vector);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(rounded(3 * a[i]), vector[i]) << i;
    if (i == 2) break;
    EXPECT_EQ(rounded(3 * a[i]), flags[i]) << i;
    EXPECT_EQ(rounded(3 * a[i]), function[i]) << i;
  }
}

TEST(Float32Rounding, HappensToPosedVertices) {
  const RigidTransform pose{{0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1}, {0.1, 0.2, 0.3}};
  const Vec3f v{1.1F, -2.3F, 0.7F};
  const double x = v.x, y = v.y, z = v.z;
  double posed[3];
  poseVertex(pose, v, posed);
  EXPECT_EQ(rounded(((0.6 * x + -0.8 * y) + 0 * z) + 0.1), posed[0]);
  EXPECT_EQ(rounded(((0.8 * x + 0.6 * y) + 0 * z) + 0.2), posed[1]);
  EXPECT_EQ(rounded(((0 * x + 0 * y) + z) + 0.3), posed[2]);
}

}  // namespace
}  // namespace deformable_contact_monitor
