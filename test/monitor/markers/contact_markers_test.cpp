// Tests the markers, and checks each one by the rules by which rviz rejects markers.
#include "monitor/markers/contact_markers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "marker_checks.h"
#include "sample_report.h"
#include "sample_step.h"

namespace deformable_contact_monitor {
namespace {

// Drawn triangles by namespace.
std::map<std::string, std::size_t> triangles(const MarkerArray& array) {
  std::map<std::string, std::size_t> counts;
  for (const Marker& m : array.markers) {
    if (m.type == Marker::TRIANGLE_LIST && m.action == Marker::ADD) {
      counts[m.ns] += m.points.size() / 3;
    }
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

TEST(ContactMarkersTest, drawRigidObjectsWhereACyclePosedThem) {
  SampleReport sample;
  sample.report.bodies[1].kind = BodyKind::kRigid;
  const MarkerArray array = ContactMarkers(MarkerOptions()).make(sample.report);
  expectValid(array);
  EXPECT_EQ(triangles(array), (Counts{{"arm/hand/cloth", 4}, {"cloth", 1}, {"base", 3}}));
  EXPECT_NE(array.markers.back().color, array.markers[2].color);
  sample.report.bodies[1].stamp = ros::Time();
  const Counts without{{"arm/hand/cloth", 4}, {"cloth", 1}};
  EXPECT_EQ(triangles(ContactMarkers(MarkerOptions()).make(sample.report)), without);
  sample.report.bodies[1].stamp = sample.report.bodies[0].stamp;
  sample.report.bodies[1].unknown_because = "no transform";
  EXPECT_EQ(triangles(ContactMarkers(MarkerOptions()).make(sample.report)), without);
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
  EXPECT_EQ(actions(markers.make(sample.report)), (Actions{"cloth", "unknown"}));
  sample.report.result = nullptr;
  sample.report.scene = nullptr;
  EXPECT_EQ(actions(markers.make(sample.report)), (Actions{"-cloth", "-unknown"}));
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

// More triangles than may be drawn: the surface is decimated, and the contacts are whole.
TEST(ContactMarkersTest, aLargeSurfaceIsDecimatedBesideItsContacts) {
  constexpr std::uint32_t kCells = 60;
  TriangleMesh sheet;
  for (std::uint32_t i = 0; i < (kCells + 1) * (kCells + 1); ++i) {
    for (const std::uint32_t c : {i % (kCells + 1), i / (kCells + 1), 0U}) {
      sheet.vertices.push_back(static_cast<float>(c));
    }
  }
  for (std::uint32_t i = 0; i + kCells + 2 < (kCells + 1) * (kCells + 1); ++i) {
    if (i % (kCells + 1) == kCells) continue;
    for (const std::uint32_t k : {i, i + 1, i + kCells + 1}) sheet.triangles.push_back(k);
    for (const std::uint32_t k : {i + 1, i + kCells + 2, i + kCells + 1}) {
      sheet.triangles.push_back(k);
    }
  }
  SampleReport sample;
  sample.scene.setMesh(2, sheet);
  MarkerOptions options;
  options.max_triangles = 2000;
  ContactMarkers markers(options);
  const MarkerArray array = markers.make(sample.report);
  expectValid(array);
  EXPECT_EQ(triangles(array).at("arm/hand/cloth"), 4U);
  const std::size_t surface = triangles(array).at("cloth");
  EXPECT_GT(surface, 300U);
  EXPECT_LE(surface, 1000U) << "contacts have their share";
  sample.result.contacts.clear();
  EXPECT_EQ(triangles(markers.make(sample.report)).at("cloth"), surface) << "it does not flicker";
  // It reaches from rim to rim.
  float high = 0;
  for (const auto& p : array.markers.back().points) high = std::max(high, static_cast<float>(p.x));
  EXPECT_GT(high, 0.9F * kCells);
  // Nearly no room beside the contacts: fewer triangles, none too many.
  for (std::uint32_t i = 0; i < 1900; ++i) sample.result.contacts.push_back({0, 0, 2, i});
  const MarkerArray full = markers.make(sample.report);
  expectValid(full);
  EXPECT_EQ(triangles(full).at("arm/hand/cloth"), 1901U);
  EXPECT_GT(triangles(full).at("cloth"), 0U);
  EXPECT_LE(triangles(full).at("cloth"), 99U);
}

TEST(PassedMarkersTest, whatPassedHasItsOwn) {
  SampleStep sample;
  ContactMarkers markers((MarkerOptions()));
  EXPECT_EQ(triangles(markers.make(sample.report)),
            (Counts{{"cloth", 1}, {"passed: arm/hand/cloth", 4}}));
  sample.result.contacts = {{0, 0, 2, 0}};
  EXPECT_EQ(triangles(markers.make(sample.report)),
            (Counts{{"arm/hand/cloth", 2}, {"cloth", 1}, {"passed: arm/hand/cloth", 2}}));
  sample.report.sweeps.clear();
  const auto last = markers.make(sample.report);
  EXPECT_EQ(triangles(last), (Counts{{"arm/hand/cloth", 2}, {"cloth", 2}}));
  bool deleted = false;
  for (const auto& marker : last.markers) {
    deleted = deleted || (marker.ns == "passed: arm/hand/cloth" && marker.action == Marker::DELETE);
  }
  EXPECT_TRUE(deleted);
}

TEST(PassedMarkersTest, theCapHolds) {
  SampleStep sample;
  MarkerOptions options;
  options.max_triangles = 3;
  ContactMarkers markers(options);
  std::size_t all = 0;
  for (const auto& [name, count] : triangles(markers.make(sample.report))) all += count;
  EXPECT_EQ(all, 3U);
}

using Point = std::array<double, 3>;
using Lines = std::vector<std::pair<Point, Point>>;

// Returns the lines by namespace.
std::map<std::string, Lines> lines(const MarkerArray& array) {
  std::map<std::string, Lines> found;
  for (const Marker& m : array.markers) {
    if (m.type != Marker::LINE_LIST || m.action != Marker::ADD) continue;
    for (std::size_t i = 0; i < m.points.size(); i += 2) {
      const auto &a = m.points[i], &b = m.points[i + 1];
      found[m.ns].push_back({{a.x, a.y, a.z}, {b.x, b.y, b.z}});
    }
  }
  return found;
}

TEST(ContactMarkersTest, geometryIsDrawnAsLinesOfTheirOwn) {
  SampleReport sample;
  sample.result.contacts.push_back({1, 0, 2, 2});
  sample.result.geometry = {{{0, 0, 0}, {2, 0, 0}, {0, 0, 1}, -0.5F, 0},
                            {{0, 4, 0}, {0, 8, 0}, {0, 0, 0}, 0, kCoplanar | kNormalUndefined},
                            {{1, 1, 1}, {1, 1, 1}, {0, -1, 0}, 0, kNormalNotUnique},
                            {{3, 3, 3}, {3, 3, 5}, {1, 0, 0}, 2, 0}};
  const MarkerArray array = ContactMarkers(MarkerOptions()).make(sample.report);
  expectValid(array);
  const float length = kNormalLengthM;
  const std::map<std::string, Lines> expected{
      {"segments: arm/hand/cloth",
       {{{0, 0, 0}, {2, 0, 0}}, {{0, 4, 0}, {0, 8, 0}}, {{1, 1, 1}, {1, 1, 1}}}},
      {"segments: base/cloth", {{{3, 3, 3}, {3, 3, 5}}}},
      {"normals: arm/hand/cloth", {{{1, 0, 0}, {1, 0, length}}, {{1, 1, 1}, {1, 1 - length, 1}}}},
      {"normals: base/cloth", {{{3, 3, 4}, {3 + length, 3, 4}}}}};
  EXPECT_EQ(lines(array), expected);
  EXPECT_EQ(triangles(array).count("arm/hand/cloth"), 1U) << "beside the triangles";
}

TEST(ContactMarkersTest, linesGoWithTheirContacts) {
  SampleReport sample;
  ContactMarkers markers{MarkerOptions()};
  sample.result.geometry.assign(3, {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0, 0});
  EXPECT_EQ(actions(markers.make(sample.report)),
            (Actions{"all", "arm/hand/cloth", "cloth", "segments: arm/hand/cloth",
                     "normals: arm/hand/cloth"}));
  for (PairGeometry& geometry : sample.result.geometry) geometry.flags = kNormalUndefined;
  EXPECT_EQ(actions(markers.make(sample.report)).front(), "-normals: arm/hand/cloth");
  sample.result.geometry.clear();
  EXPECT_EQ(actions(markers.make(sample.report)),
            (Actions{"-segments: arm/hand/cloth", "arm/hand/cloth", "cloth"}));
}

TEST(ContactMarkersTest, linesAreBoundedFiniteAndPalerWhereNear) {
  SampleReport sample;
  const PairGeometry geometry{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0, 0};
  sample.result.contacts.assign(1000, {0, 0, 2, 0});
  sample.result.geometry.assign(1000, geometry);
  MarkerOptions options;
  options.max_triangles = 100;
  const MarkerArray many = ContactMarkers(options).make(sample.report);
  expectValid(many);
  EXPECT_EQ(lines(many).at("segments: arm/hand/cloth").size(), 100U);
  EXPECT_EQ(lines(many).at("normals: arm/hand/cloth").size(), 100U);

  sample.result.contacts = {{0, 0, 2, 0}, {0, 0, 2, 1}, {0, 1, 2, 1}};
  sample.result.geometry.assign(3, geometry);
  sample.result.geometry[0].point_a.y = std::numeric_limits<float>::quiet_NaN();
  sample.result.geometry[2].normal.x = std::numeric_limits<float>::infinity();
  sample.result.separations_m = {0, 0, 0.25F};
  const MarkerArray few = ContactMarkers(MarkerOptions()).make(sample.report);
  expectValid(few);
  EXPECT_EQ(lines(few).at("segments: arm/hand/cloth").size(), 2U);
  EXPECT_EQ(lines(few).at("normals: arm/hand/cloth").size(), 1U);
  for (const Marker& m : few.markers) {
    if (m.ns.compare(0, 8, "segments") != 0) continue;
    EXPECT_GT(m.colors[2].r, m.colors[0].r);
  }
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
