// Numbers as measure_trade writes them.
#include "tools/measure_trade/trade_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

namespace deformable_contact_monitor {
namespace {

TEST(NumberText, IsShort) {
  EXPECT_EQ(numberText(0.1F), "0.1");
  EXPECT_EQ(numberText(0.1), "0.1");
  EXPECT_EQ(numberText(100.0), "100");
  EXPECT_EQ(numberText(0.0F), "0");
  EXPECT_EQ(numberText(-2.5), "-2.5");
  EXPECT_EQ(numberText(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(numberText(16777217.0), "16777217");
}

TEST(NumberText, ReadsBackAsTheSameNumber) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> number(-40, 40);
  for (int i = 0; i < 20000; ++i) {
    const double value = std::pow(10.0, number(random));
    EXPECT_EQ(std::strtod(numberText(value).c_str(), nullptr), value);
    const auto single = static_cast<float>(value);
    if (std::isfinite(single)) {
      EXPECT_EQ(std::strtof(numberText(single).c_str(), nullptr), single);
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
