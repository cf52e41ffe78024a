// Along the curve, each cell comes once, and each shares a side with the one before.
#include "core/rules/space_curve.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace deformable_contact_monitor
