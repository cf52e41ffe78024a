// Along the curve, each cell comes once, and each shares a side with the one before.
#include "core/rules/space_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

namespace deformable_contact_monitor {
namespace {

TEST(SpaceCurve, StepsFromACellToOneBesideItThroughAllCells) {
  constexpr int kBits = 5;
  constexpr std::uint32_t kSide = 1U << kBits, kCells = kSide * kSide * kSide;
  constexpr std::uint32_t kNowhere = ~0U;
  std::vector<std::uint32_t> cell(kCells, kNowhere);  // at each place
  for (std::uint32_t x = 0; x < kSide; ++x) {
    for (std::uint32_t y = 0; y < kSide; ++y) {
      for (std::uint32_t z = 0; z < kSide; ++z) {
        const std::uint32_t place = placeOnCurve<kBits>(x, y, z);
        ASSERT_LT(place, kCells);
        ASSERT_EQ(cell[place], kNowhere);
        cell[place] = (x * kSide + y) * kSide + z;
      }
    }
  }
  const auto along = [](std::uint32_t c, int axis) {
    return static_cast<int>(c >> (kBits * (2 - axis)) & (kSide - 1));
  };
  for (std::uint32_t place = 1; place < kCells; ++place) {
    int steps = 0;
    for (int axis = 0; axis < 3; ++axis) {
      steps += std::abs(along(cell[place], axis) - along(cell[place - 1], axis));
    }
    ASSERT_EQ(steps, 1) << place;
  }
}

// Corners of the box are at the curve's ends, and there is a place for anything.
TEST(SpaceCurve, HasAPlaceForAnyPointOfAnyBox) {
  constexpr std::uint32_t kPlaces = 1U << (3 * kCurveBits);
  const CurveCells unit({{0, 0, 0}, {1, 1, 1}});
  EXPECT_EQ(unit.placeOf({0, 0, 0}), 0U);
  EXPECT_EQ(unit.placeOf({1, 0, 0}), kPlaces - 1);
  for (const float most : {0.0F, 1e-45F, 1.0F, 3.4e38F, INFINITY}) {
    const CurveCells cells({{-most, -most, -most}, {most, most, most}});
    for (const float x : {0.0F, 1e-45F, 1.0F, -3.4e38F, INFINITY, -INFINITY, NAN}) {
      EXPECT_LT(cells.placeOf({x, 0, -x}), kPlaces) << x << " of " << most;
    }
  }
  EXPECT_LT(CurveCells(Aabb()).placeOf({0, 0, 0}), kPlaces);
}

}  // namespace
}  // namespace deformable_contact_monitor
