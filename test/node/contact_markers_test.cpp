// Tests of the markers, held against the rules by which rviz refuses a marker.
#include "node/contact_markers.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

bool isDrawable(const std_msgs::ColorRGBA& c) {
  return std::isfinite(c.r + c.g + c.b) && c.a > 0 && c.a <= 1;
}

// rviz's checkMarkerMsg and checkMarkerArrayMsg for what this package draws.
void expectValid(const MarkerArray& array) {
  std::set<std::pair<std::string, int>> ids;
  for (std::size_t i = 0; i < array.markers.size(); ++i) {
    const Marker& m = array.markers[i];
    SCOPED_TRACE("marker " + std::to_string(i) + " " + m.ns);
    EXPECT_TRUE(m.action != Marker::DELETEALL || i == 0);
    EXPECT_FALSE(m.header.frame_id.empty());
    EXPECT_EQ(m.pose.orientation.w, 1);
    EXPECT_EQ(m.pose.orientation.x, 0);
    EXPECT_TRUE(ids.insert({m.ns, m.id}).second);
    if (m.action != Marker::ADD) continue;
    EXPECT_EQ(m.type, Marker::TRIANGLE_LIST);
    EXPECT_GT(m.scale.x * m.scale.y * m.scale.z, 0);
    EXPECT_GT(m.lifetime.toSec(), 0);
    EXPECT_FALSE(m.points.empty());
    EXPECT_EQ(m.points.size() % 3, 0U);
    EXPECT_TRUE(m.colors.empty() || m.colors.size() == m.points.size());
    EXPECT_TRUE(isDrawable(m.color));
    for (const auto& c : m.colors) EXPECT_TRUE(isDrawable(c));
    for (const auto& p : m.points) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
  }
}

// Drawn triangles by namespace.
std::map<std::string, std::size_t> triangles(const MarkerArray& array) {
  std::map<std::string, std::size_t> counts;
  for (const Marker& m : array.markers) {
    if (m.action == Marker::ADD) counts[m.ns] += m.points.size() / 3;
  }
  return counts;
}

using Counts = std::map<std::string, std::size_t>;

TEST(ContactMarkersTest, drawContactsAndTheRestOfTheObject) {
  const SampleReport sample;
  const MarkerArray array = ContactMarkers(MarkerOptions()).make(sample.report);
  expectValid(array);
  EXPECT_EQ(triangles(array), (Counts{{"arm/hand/cloth", 4}, {"cloth", 1}}));
  ASSERT_EQ(array.markers.size(), 3U);
  for (const Marker& m : array.markers) {
    EXPECT_EQ(m.header.stamp, sample.report.header.stamp);
    EXPECT_EQ(m.header.frame_id, "base_link");
  }
  // Posed: the hand's triangles lie 5 m off, and differ in color from the cloth's.
  const Marker& contacts = array.markers[1];
  EXPECT_EQ(contacts.points[0].x, 5);
  EXPECT_EQ(contacts.points[6].x, 0);
  EXPECT_FLOAT_EQ(contacts.colors[0].a, 0.9F);
  EXPECT_NE(contacts.colors[0].g, contacts.colors[6].g);
  EXPECT_EQ(array.markers[2].points[0].z, 1);
}

TEST(ContactMarkersTest, idsStayWhileTheBodiesDo) {
  SampleReport sample;
  ContactMarkers markers{MarkerOptions()};
  const int id = markers.make(sample.report).markers[1].id;
  sample.result.contacts.insert(sample.result.contacts.begin(), {0, 2, 1, 2});
  const MarkerArray array = markers.make(sample.report);
  expectValid(array);
  EXPECT_EQ(array.markers[0].ns, "arm/hand/base");
  EXPECT_EQ(array.markers[1].ns, "arm/hand/cloth");
  EXPECT_EQ(array.markers[1].id, id);
}

// "<namespace>" drawn, "-<namespace>" deleted, "all" for DELETEALL.
std::vector<std::string> actions(const MarkerArray& array) {
  std::vector<std::string> lines;
  for (const Marker& m : array.markers) {
    lines.push_back(m.action == Marker::ADD      ? m.ns
                    : m.action == Marker::DELETE ? "-" + m.ns
                                                 : "all");
  }
  return lines;
}

using Actions = std::vector<std::string>;

TEST(ContactMarkersTest, whatHasNothingToShowAnyMoreIsDeleted) {
  SampleReport sample;
  ContactMarkers markers{MarkerOptions()};
  EXPECT_EQ(actions(markers.make(sample.report)), (Actions{"all", "arm/hand/cloth", "cloth"}));
  sample.result.contacts.clear();
  MarkerArray array = markers.make(sample.report);
  expectValid(array);
  EXPECT_EQ(actions(array), (Actions{"-arm/hand/cloth", "cloth"}));
  EXPECT_EQ(triangles(array), (Counts{{"cloth", 3}}));

  sample.report.bodies[2].unknown_because = "stale";
  EXPECT_EQ(actions(markers.make(sample.report)), Actions{"-cloth"});
  sample.report.result = nullptr;
  sample.report.scene = nullptr;
  EXPECT_TRUE(markers.make(sample.report).markers.empty());
}

TEST(ContactMarkersTest, anotherObjectsCycleLeavesThemAlone) {
  SampleReport sample;
  ContactMarkers markers{MarkerOptions()};
  markers.make(sample.report);
  sample.report.bodies[2].triggered = false;
  sample.result.contacts.clear();
  EXPECT_TRUE(markers.make(sample.report).markers.empty());
  sample.report.bodies[2].triggered = true;
  EXPECT_EQ(actions(markers.make(sample.report)), (Actions{"-arm/hand/cloth", "cloth"}));
}

TEST(ContactMarkersTest, theCapHoldsAndContactsComeFirst) {
  const SampleReport sample;
  for (std::size_t cap = 1; cap <= 6; ++cap) {
    MarkerOptions options;
    options.max_triangles = cap;
    const MarkerArray array = ContactMarkers(options).make(sample.report);
    expectValid(array);
    const Counts counts = triangles(array);
    std::size_t total = 0;
    for (const auto& [ns, count] : counts) total += count;
    EXPECT_LE(total, cap);
    EXPECT_EQ(counts.count("arm/hand/cloth"), cap >= 2 ? 1U : 0U) << cap;
  }
}

TEST(ContactMarkersTest, whatIsOnlyNearIsPalerAndComesLast) {
  SampleReport sample;
  const MarkerArray touching = ContactMarkers(MarkerOptions()).make(sample.report);
  // Hand 0 with cloth 0 and 1, hand 1 with cloth 1: the last pair alone touches.
  sample.result.separations_m = {0.25F, 0.125F, 0};
  const MarkerArray array = ContactMarkers(MarkerOptions()).make(sample.report);
  expectValid(array);
  EXPECT_EQ(triangles(array), triangles(touching));
  const auto& strong = touching.markers[1].colors;  // hand 0, hand 1, cloth 0, cloth 1
  const auto& colors = array.markers[1].colors;     // hand 1, hand 0, cloth 1, cloth 0
  ASSERT_EQ(colors.size(), 12U);
  EXPECT_EQ(array.markers[1].points[1].y, 1) << "hand 1";
  for (const std::size_t object : {0, 6}) {
    EXPECT_EQ(colors[object], strong[object]);
    EXPECT_GT(colors[object + 3].b, strong[object + 3].b);
  }
  MarkerOptions options;
  options.max_triangles = 2;
  const MarkerArray two = ContactMarkers(options).make(sample.report);
  EXPECT_EQ(triangles(two), (Counts{{"arm/hand/cloth", 2}}));
  EXPECT_EQ(two.markers[1].colors[0], strong[0]);
  EXPECT_EQ(two.markers[1].colors[3], strong[6]);
}

TEST(ContactMarkersTest, nonFiniteTrianglesAreLeftOut) {
  SampleReport sample;
  TriangleMesh mesh = threeTriangles();
  mesh.vertices[3 * 4] = std::numeric_limits<float>::quiet_NaN();
  sample.scene.setMesh(2, mesh);
  const MarkerArray array = ContactMarkers(MarkerOptions()).make(sample.report);
  expectValid(array);
  EXPECT_EQ(triangles(array), (Counts{{"arm/hand/cloth", 4}}));
}

TEST(MarkerRateTest, EachBodyHasItsOwn) {
  const SampleReport sample;
  CycleReport cloths = sample.report, links = sample.report;
  links.bodies[0].triggered = true;
  links.bodies[2].triggered = false;
  MarkerRate rate(10);
  const SteadyTime start{std::chrono::hours(7)};
  const auto at = [start](int ms) { return start + std::chrono::milliseconds(ms); };
  EXPECT_TRUE(rate.isDue(cloths, at(0)));
  EXPECT_TRUE(rate.isDue(links, at(1)));
  EXPECT_FALSE(rate.isDue(cloths, at(99)));
  EXPECT_TRUE(rate.isDue(cloths, at(100)));
  EXPECT_FALSE(rate.isDue(links, at(100)));
  int drawn = 0;
  for (int ms = 1000; ms < 2000; ++ms) drawn += rate.isDue(cloths, at(ms)) ? 1 : 0;
  EXPECT_EQ(drawn, 10) << "a second of 1000 Hz";
  cloths.bodies[2].triggered = false;
  EXPECT_FALSE(rate.isDue(cloths, at(9000))) << "nobody's cycle";
}

}  // namespace
}  // namespace deformable_contact_monitor
