// A list in which contacts stand twice, as a cycle that is cut off may leave it.
#include <gtest/gtest.h>

#include <vector>

#include "cuda/stages/output.cuh"
#include "pair_sets.h"

namespace deformable_contact_monitor {
namespace {

TEST(DropRepeated, WhatComesWithAContactStaysWithIt) {
  DetectionResult result;
  const std::uint32_t numbers[] = {1, 1, 2, 3, 3, 3};
  for (const std::uint32_t n : numbers) {
    result.contacts.push_back({0, n, 1, n});
    result.separations_m.push_back(static_cast<float>(n));
    result.geometry.emplace_back();
    result.geometry.back().separation_m = static_cast<float>(n);
  }
  dropRepeated(result);
  EXPECT_TRUE(samePairs({{0, 1, 1, 1}, {0, 2, 1, 2}, {0, 3, 1, 3}}, result.contacts));
  EXPECT_EQ(std::vector<float>({1, 2, 3}), result.separations_m);
  ASSERT_EQ(3U, result.geometry.size());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(i + 1, result.geometry[i].separation_m);
}

TEST(DropRepeated, OfPairsAlone) {
  DetectionResult result;
  result.contacts = {{0, 1, 1, 1}, {0, 1, 1, 1}};
  dropRepeated(result);
  EXPECT_EQ(1U, result.contacts.size());
  EXPECT_TRUE(result.separations_m.empty());
  EXPECT_TRUE(result.geometry.empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
