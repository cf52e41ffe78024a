// Tests the markers of bodies that are in contact although no pair of their triangles is listed.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "marker_checks.h"
#include "monitor/markers/contact_markers.h"
#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

constexpr char kOfHand[] = "witness: arm/hand/cloth";

// Hand and cloth 2 mm apart, with a margin of 20 mm at 5 mm tolerance, and base and cloth far
// apart; no contact is listed.
class WitnessMarkersTest : public ::testing::Test {
 protected:
  WitnessMarkersTest() {
    sample_.scene.setMargin(2, 0.02F);
    sample_.report.options.tolerance_m = 0.005F;
    sample_.result.contacts.clear();
    sample_.result.distances.resize(2);
    hand().body_a = 0;
    hand().body_b = base().body_b = 2;
    base().body_a = 1;
    base().low_m = base().high_m = 3;
    hand().low_m = 0.001F;
    hand().high_m = 0.002F;
    hand().point_a = base().point_a = {1, 2, 3};
    hand().point_b = base().point_b = {1, 2, 3.002F};
  }

  BodyDistance& hand() { return sample_.result.distances[0]; }
  BodyDistance& base() { return sample_.result.distances[1]; }

  // The witnesses drawn in the report's cycle.
  std::vector<Marker> witnesses() {
    MarkerArray array = ContactMarkers(MarkerOptions()).make(sample_.report);
    expectValid(array);
    std::vector<Marker> markers;
    std::copy_if(array.markers.begin(), array.markers.end(), std::back_inserter(markers),
                 [](const Marker& m) { return m.ns.find(kWitness) == 0; });
    return markers;
  }

  SampleReport sample_;
};

TEST_F(WitnessMarkersTest, AContactWithoutTrianglesHasItsTwoPoints) {
  const std::vector<Marker> markers = witnesses();
  ASSERT_EQ(markers.size(), 1U);
  const Marker& marker = markers[0];
  EXPECT_EQ(marker.ns, kOfHand);
  EXPECT_EQ(marker.type, Marker::SPHERE_LIST);
  ASSERT_EQ(marker.points.size(), 2U);
  EXPECT_EQ(marker.points[0].x, 1);
  EXPECT_EQ(marker.points[0].y, 2);
  EXPECT_EQ(marker.points[0].z, 3);
  EXPECT_EQ(marker.points[1].z, 3.002F);
  ASSERT_EQ(marker.colors.size(), 2U);
  EXPECT_LT(marker.colors[0].g, marker.colors[1].g) << "the link is red, the object yellow";
  EXPECT_LT(marker.scale.x, 0.1);
}

TEST_F(WitnessMarkersTest, WhatIsNoContactHasNone) {
  hand().high_m = 0.0051F;
  EXPECT_TRUE(witnesses().empty()) << "near";
  hand().low_m = 0.03F;
  EXPECT_TRUE(witnesses().empty()) << "none";
  hand().low_m = 0;
  hand().high_m = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(witnesses().empty()) << "open";
  hand().high_m = 0;
  EXPECT_EQ(witnesses().size(), 1U);
}

TEST_F(WitnessMarkersTest, WhereTrianglesTouchTheyAreThePicture) {
  sample_.result.contacts = {{0, 0, 2, 0}};
  EXPECT_TRUE(witnesses().empty());
  sample_.result.separations_m = {0.002F};
  EXPECT_EQ(witnesses().size(), 1U) << "a pair of triangles that is only near is none of a contact";
}

TEST_F(WitnessMarkersTest, ItGoesWithItsContactAndKeepsItsId) {
  ContactMarkers markers{MarkerOptions()};
  const auto make = [&] {
    const MarkerArray array = markers.make(sample_.report);
    expectValid(array);
    return array;
  };
  MarkerArray array = make();
  EXPECT_EQ(actions(array), (Actions{"all", "cloth", kOfHand}));
  const int id = array.markers.back().id;
  base().low_m = base().high_m = 0;
  array = make();
  EXPECT_EQ(actions(array), (Actions{"cloth", kOfHand, "witness: base/cloth"}));
  EXPECT_EQ(array.markers[1].id, id);
  EXPECT_NE(array.markers[2].id, id);
  sample_.result.distances.clear();
  EXPECT_EQ(actions(make()),
            (Actions{"-witness: arm/hand/cloth", "-witness: base/cloth", "cloth"}));
}

TEST_F(WitnessMarkersTest, OfAnotherBodysCycleNothingIsSaid) {
  sample_.report.bodies[2].triggered = false;
  EXPECT_TRUE(witnesses().empty());
  sample_.report.bodies[2].triggered = true;
  sample_.report.result = nullptr;
  EXPECT_TRUE(witnesses().empty());
}

// rviz refuses a marker that has one.
TEST_F(WitnessMarkersTest, PointsThatAreNotFiniteAreNotDrawn) {
  hand().point_b.y = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(witnesses().empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
