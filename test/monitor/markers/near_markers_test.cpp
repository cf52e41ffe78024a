// Tests the lines between the nearest points of bodies that are NEAR, and their texts.
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "marker_checks.h"
#include "monitor/markers/contact_markers.h"
#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

constexpr char kLine[] = "nearest: arm/hand/cloth", kText[] = "distance: arm/hand/cloth";

// Hand and cloth are 62.5 mm apart.
class NearMarkersTest : public ::testing::Test {
 protected:
  NearMarkersTest() {
    sample_.result.contacts.clear();
    sample_.result.nearest = {{{0, 1, 2, 2}, 0.0625F, {1, 2, 3}, {1, 2, 3.0625F}, {0, 0, 1}}};
  }

  NearestPair& nearest() { return sample_.result.nearest[0]; }
  MarkerArray make() {
    MarkerArray array = markers_.make(sample_.report);
    expectValid(array);
    return array;
  }

  SampleReport sample_;
  ContactMarkers markers_{MarkerOptions()};
};

TEST_F(NearMarkersTest, ALineJoinsTheNearestPointsAndATextSaysHowFar) {
  const MarkerArray array = make();
  ASSERT_EQ(actions(array), (Actions{"all", "cloth", kLine, kText}));
  const Marker &line = array.markers[2], &text = array.markers[3];
  EXPECT_EQ(line.type, Marker::LINE_LIST);
  ASSERT_EQ(line.points.size(), 2U);
  EXPECT_EQ(line.points[0].x, 1);
  EXPECT_EQ(line.points[0].y, 2);
  EXPECT_EQ(line.points[0].z, 3);
  EXPECT_EQ(line.points[1].z, 3.0625);
  EXPECT_LT(line.colors.at(0).g, line.colors.at(1).g) << "the link's end is red";
  EXPECT_EQ(text.type, Marker::TEXT_VIEW_FACING);
  EXPECT_EQ(text.text, "0.0625 m");
  EXPECT_EQ(text.pose.position.x, 1);
  EXPECT_GT(text.pose.position.z, 3.03);
}

TEST_F(NearMarkersTest, TheyGoWhenThePairIsNotNearAndKeepTheirIds) {
  const MarkerArray first = make();
  nearest().distance_m = 2;
  const MarkerArray second = make();
  EXPECT_EQ(actions(second), (Actions{"cloth", kLine, kText}));
  EXPECT_EQ(second.markers[1].id, first.markers[2].id);
  EXPECT_EQ(second.markers[2].text, "2 m");
  sample_.result.nearest.clear();
  EXPECT_EQ(actions(make()),
            (Actions{"-distance: arm/hand/cloth", "-nearest: arm/hand/cloth", "cloth"}));
}

TEST_F(NearMarkersTest, WhatIsUnknownOrTouchesHasNone) {
  make();
  sample_.result.cutOff("no time");
  EXPECT_EQ(actions(make()).back(), "cloth") << "unknown";
  sample_.result.cut_off = false;
  EXPECT_EQ(actions(make()).back(), kText);
  nearest().distance_m = 0;
  EXPECT_EQ(actions(make()).back(), "cloth") << "in contact";
  sample_.report.result = nullptr;
  EXPECT_EQ(actions(make()).back(), "cloth") << "no detection ran";
}

// rviz rejects a marker that has one.
TEST_F(NearMarkersTest, PointsThatAreNotFiniteAreNotDrawn) {
  nearest().point_b.y = std::numeric_limits<float>::infinity();
  EXPECT_EQ(actions(make()), (Actions{"all", "cloth"}));
}

}  // namespace
}  // namespace deformable_contact_monitor
