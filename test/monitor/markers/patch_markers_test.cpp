// Tests the markers of patches, and checks each one by the rules by which rviz rejects markers.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "monitor/markers/contact_markers.h"
#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

Patch patchOf(BodyId a, std::uint32_t id, Vec3d normal = {0, 0, 1}) {
  Patch patch;
  patch.body_a = a;
  patch.body_b = 2;
  patch.id = id;
  patch.pair_count = 3;
  patch.triangles_a = {0, 1};
  patch.triangles_b = {2};
  patch.centroid = {1, 2, 3};
  patch.normal = normal;
  return patch;
}

// rviz's checks for these types.
void expectValid(const MarkerArray& array) {
  std::set<std::pair<std::string, int>> ids;
  for (const Marker& m : array.markers) {
    EXPECT_FALSE(m.header.frame_id.empty());
    EXPECT_EQ(m.pose.orientation.w, 1);
    EXPECT_TRUE(ids.insert({m.ns, m.id}).second);
    EXPECT_GE(m.id, 0);
    if (m.action != Marker::ADD) continue;
    EXPECT_GT(m.lifetime.toSec(), 0);
    EXPECT_GT(m.color.a, 0);
    EXPECT_GT(m.color.r + m.color.g + m.color.b, 0.5);
    EXPECT_EQ(m.type == Marker::TEXT_VIEW_FACING, m.points.empty());
    EXPECT_EQ(m.type == Marker::TEXT_VIEW_FACING, !m.text.empty());
    if (m.type == Marker::LINE_LIST) {
      EXPECT_GT(m.scale.x, 0);
      EXPECT_EQ(m.points.size() % 2, 0U);
    } else if (m.type == Marker::ARROW) {
      EXPECT_GT(m.scale.x * m.scale.y, 0);
      EXPECT_EQ(m.points.size(), 2U);
    } else {
      EXPECT_GT(m.scale.z, 0);
    }
    for (const auto& p : m.points) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
  }
}

class PatchMarkersTest : public ::testing::Test {
 protected:
  // "ADD <ns> <type>" or "DELETE <ns>", of each.
  std::multiset<std::string> draw(const std::vector<Patch>* patches) {
    array_ = MarkerArray();
    markers_.add(sample_.report, patches, &array_);
    expectValid(array_);
    std::multiset<std::string> lines;
    for (const Marker& m : array_.markers) {
      lines.insert(m.action == Marker::ADD ? "ADD " + m.ns + " " + std::to_string(m.type)
                                           : "DELETE " + m.ns);
    }
    return lines;
  }

  using Lines = std::multiset<std::string>;
  const std::string hand_ = "patch: arm/hand/cloth", base_ = "patch: base/cloth";

  SampleReport sample_;
  PatchMarkers markers_{MarkerOptions()};
  MarkerArray array_;
};

TEST_F(PatchMarkersTest, AreOutlineArrowAndText) {
  const std::vector<Patch> patches = {patchOf(0, 7)};
  EXPECT_EQ(draw(&patches),
            (Lines{"ADD " + hand_ + " 0", "ADD " + hand_ + " 5", "ADD " + hand_ + " 9"}));
  EXPECT_EQ(array_.markers[0].points.size(), 18U) << "three triangles of three lines";
  EXPECT_EQ(array_.markers[0].points[0].x, 5) << "of the hand as it is posed";
  EXPECT_EQ(array_.markers[1].points[0].z, 3);
  EXPECT_GT(array_.markers[1].points[1].z, 3);
  EXPECT_EQ(array_.markers[2].text, "7");
}

TEST_F(PatchMarkersTest, WithoutANormalThereIsNoArrow) {
  std::vector<Patch> patches = {patchOf(0, 7)};
  draw(&patches);
  patches[0].normal = Vec3d();
  EXPECT_EQ(draw(&patches),
            (Lines{"ADD " + hand_ + " 5", "ADD " + hand_ + " 9", "DELETE " + hand_}));
}

TEST_F(PatchMarkersTest, WhatVanishedIsDeletedOnce) {
  const std::vector<Patch> patches = {patchOf(0, 7), patchOf(1, 8)}, none;
  EXPECT_EQ(draw(&patches).size(), 6U);
  EXPECT_EQ(draw(&none), (Lines{"DELETE " + hand_, "DELETE " + hand_, "DELETE " + hand_,
                                "DELETE " + base_, "DELETE " + base_, "DELETE " + base_}));
  EXPECT_EQ(draw(&none), Lines());
  draw(&patches);
  EXPECT_EQ(draw(nullptr).count("DELETE " + hand_), 3U) << "nobody asks for patches any more";
  EXPECT_EQ(draw(nullptr), Lines());
}

TEST_F(PatchMarkersTest, AnotherObjectsCycleLeavesThemAlone) {
  const std::vector<Patch> patches = {patchOf(0, 7)}, none;
  draw(&patches);
  sample_.report.bodies[2].triggered = false;
  EXPECT_EQ(draw(&none), Lines());
}

TEST_F(PatchMarkersTest, TheCapHolds) {
  MarkerOptions options;
  options.max_triangles = 4;
  markers_ = PatchMarkers(options);
  const std::vector<Patch> patches = {patchOf(0, 7), patchOf(1, 4000000000U)};
  draw(&patches);
  EXPECT_EQ(array_.markers[0].points.size(), 12U) << "one triangle of each side";
}

}  // namespace
}  // namespace deformable_contact_monitor
