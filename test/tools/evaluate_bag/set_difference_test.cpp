// How the contacts of two runs differ.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <random>
#include <set>
#include <vector>

#include "scenes.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {
namespace {

TEST(SetDifference, IsTheStandardLibrarys) {
  const Scene scene = pairScene(clothGrid(4, 1, 0, 0), clothGrid(4, 1, 0, 0));
  std::mt19937 random(1);
  for (int trial = 0; trial < 500; ++trial) {
    std::set<TrianglePair> sets[2];
    for (auto& set : sets) {
      for (auto i = random() % 8; i > 0; --i) {
        set.insert({0, static_cast<std::uint32_t>(random() % 3), 1,
                    static_cast<std::uint32_t>(random() % 3)});
      }
    }
    DetectionResult results[2];
    for (int k = 0; k < 2; ++k) results[k].contacts.assign(sets[k].begin(), sets[k].end());
    std::vector<TrianglePair> only[2];
    for (int k = 0; k < 2; ++k) {
      std::set_difference(sets[k].begin(), sets[k].end(), sets[1 - k].begin(), sets[1 - k].end(),
                          std::back_inserter(only[k]));
    }
    const SetDifference found = difference(scene, results[0], results[1]);
    EXPECT_EQ(found.only_a, only[0].size());
    EXPECT_EQ(found.only_b, only[1].size());
    EXPECT_EQ(found.isEmpty(), sets[0] == sets[1]);
    EXPECT_EQ(found.example.empty(), found.isEmpty());
  }
}

// A list that was cut lacks contacts that the other one has. Their number must be right.
TEST(SetDifference, WhatAListHadNoRoomForIsNone) {
  Scene scene;
  for (const char* name : {"link", "cloth"}) scene.addBody(name, TriangleMesh());
  DetectionResult whole, cut;
  whole.contacts = {{0, 0, 1, 0}, {0, 0, 1, 1}, {0, 1, 1, 0}};
  cut.contacts = {{0, 0, 1, 1}};
  cut.left_out = 2;
  EXPECT_TRUE(difference(scene, whole, cut).isEmpty());
  EXPECT_TRUE(difference(scene, cut, whole).isEmpty());
  EXPECT_EQ(difference(scene, cut, whole).example, "");
  cut.left_out = 1;
  EXPECT_EQ(difference(scene, whole, cut).only_a, 1U);
  cut.left_out = 3;
  EXPECT_EQ(difference(scene, whole, cut).only_b, 1U);
  EXPECT_EQ(difference(scene, whole, cut).example,
            "the first has 3 contacts, the second 4, not all of them listed");
  cut.left_out = 2;
  cut.contacts = {{0, 2, 1, 1}};
  EXPECT_EQ(difference(scene, cut, whole).only_a, 1U);
}

}  // namespace
}  // namespace deformable_contact_monitor
