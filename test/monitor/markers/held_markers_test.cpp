// Tests the text over attached objects, and the color of the part that is held.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "monitor/markers/contact_markers.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;

class HeldMarkersTest : public ::testing::Test {
 protected:
  HeldMarkersTest() {
    const float infinite = std::numeric_limits<float>::infinity();
    for (const char* name : {"hand", "cloth"}) {
      BodyStatus body;
      body.name = name;
      report_.bodies.push_back(body);
    }
    report_.bodies[1].kind = BodyKind::kDeformable;
    report_.bodies[1].triggered = true;
    report_.header.frame_id = "base";
    report_.attached = {{"cloth", {{"finger", "hand"}}}, {"elsewhere", {{"hand"}}}};
    scene_.addBody("hand", TriangleMesh());
    scene_.addBody("cloth", {{0, 0, 0, 1, 0, 0, 0, 0.5F, 2, infinite, 0, 0}, {0, 1, 2, 1, 2, 3}});
    scene_.setPose(1, RigidTransform());
    report_.scene = &scene_;
  }

  std::vector<Marker> markers() const {
    visualization_msgs::MarkerArray array;
    addHeldMarkers(report_, 0.25, &array);
    return array.markers;
  }

  Scene scene_;
  CycleReport report_;
};

TEST_F(HeldMarkersTest, ItSaysByWhomAndStandsOverTheObject) {
  ASSERT_EQ(markers().size(), 1U);
  const Marker marker = markers().front();
  EXPECT_EQ(marker.text, "held: cloth by finger, hand");
  EXPECT_EQ(marker.ns, "held");
  EXPECT_EQ(marker.type, Marker::TEXT_VIEW_FACING);
  EXPECT_EQ(marker.header.frame_id, "base");
  EXPECT_EQ(marker.lifetime, ros::Duration(0.25));
  EXPECT_EQ(marker.pose.position.x, 0.5);
  EXPECT_EQ(marker.pose.position.y, 0.25);
  EXPECT_GT(marker.pose.position.z, 2);
  EXPECT_GT(marker.scale.z, 0);
  EXPECT_GT(marker.color.a, 0);
}

TEST_F(HeldMarkersTest, NothingIsDrawnOfWhatIsNotHeldOrNotKnown) {
  report_.bodies[1].triggered = false;
  EXPECT_TRUE(markers().empty()) << "it is not its cycle";
  report_.bodies[1].triggered = true;
  report_.bodies[1].unknown_because = "no mesh yet";
  EXPECT_TRUE(markers().empty());
  report_.bodies[1].unknown_because = "";
  report_.attached.erase("cloth");
  EXPECT_TRUE(markers().empty());
  report_.attached = {{"cloth", {{"hand"}}}};
  report_.scene = nullptr;
  EXPECT_TRUE(markers().empty());
}

TEST_F(HeldMarkersTest, ARigidObjectIsHeldWhereACyclePosedIt) {
  report_.bodies[1].kind = BodyKind::kRigid;
  report_.bodies[1].triggered = false;
  EXPECT_TRUE(markers().empty()) << "not posed";
  report_.bodies[1].stamp = ros::Time(1);
  EXPECT_EQ(markers().size(), 1U);
}

std::map<std::string, std::size_t> trianglesOf(const visualization_msgs::MarkerArray& array) {
  std::map<std::string, std::size_t> triangles;
  for (const Marker& marker : array.markers) {
    if (marker.action == Marker::ADD && marker.type == Marker::TRIANGLE_LIST) {
      triangles[marker.ns] = marker.points.size() / 3;
    }
  }
  return triangles;
}

TEST_F(HeldMarkersTest, TheHeldPartHasItsOwnColor) {
  using Triangles = std::map<std::string, std::size_t>;
  scene_.setMesh(1, {{0, 0, 0, 1, 0, 0, 0, 0.5F, 2, 3, 0, 0}, {0, 1, 2, 1, 2, 3, 0, 1, 3}});
  BodyParts parts;
  parts.names = {"hem", kHeldPart};
  parts.held_of = {0, 1};
  report_.bodies[1].parts = std::make_shared<const BodyParts>(parts);
  scene_.setParts(1, {3, 0, 2});
  ContactMarkers markers{MarkerOptions()};
  EXPECT_EQ(trianglesOf(markers.make(report_)), (Triangles{{"cloth", 1}, {"held: cloth", 2}}));

  scene_.setParts(1, {});
  report_.bodies[1].parts = nullptr;
  const visualization_msgs::MarkerArray released = markers.make(report_);
  EXPECT_EQ(trianglesOf(released), (Triangles{{"cloth", 3}}));
  EXPECT_TRUE(std::any_of(released.markers.begin(), released.markers.end(), [](const Marker& one) {
    return one.ns == "held: cloth" && one.action == Marker::DELETE;
  }));
}

TEST_F(HeldMarkersTest, NamedPartsHaveTheirOwnColors) {
  scene_.setMesh(1, {{0, 0, 0, 1, 0, 0, 0, 0.5F, 2, 3, 0, 0}, {0, 1, 2, 1, 2, 3, 0, 1, 3}});
  BodyParts parts;
  parts.names = {"hem", "logo"};
  report_.bodies[1].parts = std::make_shared<const BodyParts>(parts);
  scene_.setParts(1, {2, 0, 1});
  const Marker surface = ContactMarkers(MarkerOptions()).make(report_).markers.back();
  ASSERT_EQ(surface.colors.size(), 9U);
  EXPECT_EQ(surface.colors[3], surface.color) << "what no part has";
  EXPECT_NE(surface.colors[0], surface.color);
  EXPECT_NE(surface.colors[6], surface.color);
  EXPECT_NE(surface.colors[6], surface.colors[0]);
  EXPECT_EQ(surface.colors[6].a, surface.color.a);
}

}  // namespace
}  // namespace deformable_contact_monitor
