// Tests the conversions to and from messages.
#include "monitor/messages/contact_messages.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

using PairList = std::vector<std::array<std::uint32_t, 4>>;

PairList pairsOf(const ContactArray& message) {
  PairList pairs;
  for (const auto& p : message.pairs) {
    pairs.push_back({p.body_a, p.triangle_a, p.body_b, p.triangle_b});
  }
  return pairs;
}

TEST(ContactArrayTest, carriesTheWholeReport) {
  const SampleReport sample;
  const ContactArray message = toContactArray(sample.report, 0);
  EXPECT_EQ(message.header.stamp, ros::Time(100, 500));
  EXPECT_EQ(message.header.frame_id, "base_link");
  EXPECT_EQ(message.cycle, 7U);
  EXPECT_EQ(message.bodies, (std::vector<std::string>{"arm/hand", "base", "cloth"}));
  EXPECT_EQ(message.body_kind, (std::vector<std::uint8_t>{ContactArray::LINK, ContactArray::LINK,
                                                          ContactArray::DEFORMABLE}));
  SampleReport rigid;
  rigid.report.bodies[1].kind = BodyKind::kRigid;
  EXPECT_EQ(toContactArray(rigid.report, 0).body_kind[1], ContactArray::RIGID);
  EXPECT_EQ(message.triggered, (std::vector<std::uint8_t>{0, 0, 1}));
  EXPECT_EQ(message.body_stamps, std::vector<ros::Time>(3, ros::Time(100, 500)));
  EXPECT_EQ(message.topology_ids, (std::vector<std::uint32_t>{0, 0, 9}));
  EXPECT_EQ(pairsOf(message), (PairList{{0, 0, 2, 0}, {0, 0, 2, 1}, {0, 1, 2, 1}}));
  EXPECT_TRUE(message.geometry.empty());
  EXPECT_EQ(message.pair_count, 3U);
  EXPECT_TRUE(message.complete);
  EXPECT_TRUE(message.guaranteed);
  EXPECT_FALSE(message.truncated);
  EXPECT_TRUE(message.skipped.empty());
  EXPECT_EQ(message.backend, "cpu");
  EXPECT_EQ(message.predicates, "exact");
  EXPECT_EQ(message.overlap, 1);
  EXPECT_EQ(message.tolerance, 0);
  EXPECT_NEAR(message.compute_time.toSec(), 2.5e-3, 1e-9);
  EXPECT_NEAR(message.age.toSec(), 0.25, 1e-9);
}

TEST(ContactArrayTest, carriesTheNearestPairs) {
  SampleReport sample;
  sample.result.nearest = {{{0, 1, 2, 3}, 0.5F, {1, 2, 3}, {4, 5, 6}, {0, 0, 1}},
                           {{1, 4, 2, 5}, 0, {7, 8, 9}, {7, 8, 9}, {}}};
  const ContactArray message = toContactArray(sample.report, 0);
  ASSERT_EQ(message.nearest.size(), 2U);
  const NearestTriangles &near = message.nearest[0], &touching = message.nearest[1];
  EXPECT_EQ(near.body_a, 0U);
  EXPECT_EQ(near.triangle_a, 1U);
  EXPECT_EQ(near.body_b, 2U);
  EXPECT_EQ(near.triangle_b, 3U);
  EXPECT_EQ(near.distance, 0.5F);
  EXPECT_EQ(near.point_a, toPoint32(Vec3f{1, 2, 3}));
  EXPECT_EQ(near.point_b, toPoint32(Vec3f{4, 5, 6}));
  EXPECT_EQ(touching.body_a, 1U);
  EXPECT_EQ(touching.distance, 0);
  EXPECT_EQ(touching.point_b, toPoint32(Vec3f{7, 8, 9}));
  EXPECT_EQ(message.pair_count, 3U) << "of the list";
}

TEST(ContactArrayTest, truncationKeepsTheFirstPairsAndTheCount) {
  const SampleReport sample;
  const ContactArray cut = toContactArray(sample.report, 2);
  EXPECT_EQ(pairsOf(cut), (PairList{{0, 0, 2, 0}, {0, 0, 2, 1}}));
  EXPECT_EQ(cut.pair_count, 3U);
  EXPECT_TRUE(cut.truncated);
  EXPECT_TRUE(cut.guaranteed);
  EXPECT_FALSE(cut.complete);

  const ContactArray whole = toContactArray(sample.report, 3);
  EXPECT_EQ(whole.pairs.size(), 3U);
  EXPECT_FALSE(whole.truncated);
  EXPECT_TRUE(whole.complete);
}

TEST(ContactArrayTest, aMessageHoldsAsManyPairsAsHaveRoom) {
  EXPECT_EQ(mostPairs(1000, 0, 16), 62U);
  EXPECT_EQ(mostPairs(1000, 8, 16), 62U);
  EXPECT_EQ(mostPairs(1000, 9, 16), 61U);
  EXPECT_EQ(mostPairs(1000, 984, 16), 1U);
  EXPECT_EQ(mostPairs(1000, 985, 16), 0U);
  EXPECT_EQ(mostPairs(1000, 1001, 16), 0U);
  EXPECT_LT(kMostMessageBytes, 1000000000U) << "roscpp drops connections for more";
  EXPECT_EQ(mostPairs(kMostMessageBytes, 4000, 16), 56249750U);
}

TEST(ContactArrayTest, beyondItsRoomItIsTruncatedAndSaysSo) {
  SampleReport sample;
  sample.result.nearest.resize(1);  // takes room too
  const auto bytesOf = [](const ContactArray& message) {
    return ros::serialization::serializationLength(message);
  };
  const ContactArray whole = toContactArray(sample.report, 0);
  EXPECT_EQ(toContactArray(sample.report, 0, bytesOf(whole)).pairs.size(), 3U);
  const ContactArray cut = toContactArray(sample.report, 0, bytesOf(whole) - 1);
  EXPECT_EQ(pairsOf(cut), (PairList{{0, 0, 2, 0}, {0, 0, 2, 1}}));
  EXPECT_EQ(bytesOf(cut), bytesOf(whole) - 16);
  EXPECT_EQ(cut.pair_count, 3U);
  EXPECT_TRUE(cut.truncated);
  EXPECT_FALSE(cut.complete);
  EXPECT_EQ(toContactArray(sample.report, 1, bytesOf(whole) - 1).pairs.size(), 1U);
  EXPECT_EQ(toContactArray(sample.report, 3, bytesOf(whole) - 1).pairs.size(), 2U);
  EXPECT_TRUE(toContactArray(sample.report, 0, 1).pairs.empty());
}

// Adds geometry to each of the three contacts, as if the parameters asked for it.
void addGeometry(SampleReport* sample) {
  sample->report.options.geometry = true;
  for (int i = 0; i < 3; ++i) {
    const auto x = static_cast<float>(i);
    sample->result.geometry.push_back(
        {{x, 1, 2}, {x, 3, 4}, {0, 0, -1}, -0.5F * x, static_cast<std::uint8_t>(i)});
  }
}

TEST(ContactArrayTest, carriesTheGeometryOfEachPair) {
  SampleReport sample;
  addGeometry(&sample);
  const ContactArray message = toContactArray(sample.report, 0);
  ASSERT_EQ(message.geometry.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto& g = message.geometry[i];
    EXPECT_EQ(std::vector<float>({g.point_a.x, g.point_a.y, g.point_a.z}),
              std::vector<float>({1.0F * i, 1, 2}));
    EXPECT_EQ(std::vector<float>({g.point_b.x, g.point_b.y, g.point_b.z}),
              std::vector<float>({1.0F * i, 3, 4}));
    EXPECT_EQ(std::vector<float>({g.normal.x, g.normal.y, g.normal.z}),
              std::vector<float>({0, 0, -1}));
    EXPECT_EQ(g.separation, -0.5F * i);
    EXPECT_EQ(g.flags, i);
  }
  EXPECT_EQ(toContactArray(sample.report, 2).geometry.size(), 2U);
}

TEST(ContactArrayTest, aMessageHasRoomForGeometryToo) {
  SampleReport sample;
  addGeometry(&sample);
  const auto bytesOf = [](const ContactArray& message) {
    return ros::serialization::serializationLength(message);
  };
  const ContactArray whole = toContactArray(sample.report, 0);
  EXPECT_EQ(toContactArray(sample.report, 0, bytesOf(whole)).geometry.size(), 3U);
  const ContactArray cut = toContactArray(sample.report, 0, bytesOf(whole) - 1);
  EXPECT_EQ(cut.pairs.size(), 2U);
  EXPECT_EQ(cut.geometry.size(), 2U);
  EXPECT_EQ(bytesOf(cut), bytesOf(whole) - 16 - 41);
}

// Somebody else may have asked the detector for it; or there was no time for it.
TEST(ContactArrayTest, geometryIsThereIfTheParametersAskForItAndAllOfItIsThere) {
  SampleReport others;
  addGeometry(&others);
  others.report.options.geometry = false;
  EXPECT_TRUE(toContactArray(others.report, 0).geometry.empty());
  SampleReport late;
  late.report.options.geometry = true;
  EXPECT_TRUE(toContactArray(late.report, 0).geometry.empty());
  EXPECT_EQ(toContactArray(late.report, 0).pairs.size(), 3U);
}

TEST(ContactArrayTest, countsStopAtWhatTheirFieldsHold) {
  SampleReport sample;
  sample.result.left_out = std::uint64_t{1} << 33;
  sample.result.counters.undecided = std::uint64_t{1} << 32;
  sample.result.counters.rejected = (std::uint64_t{1} << 32) + 5;
  const ContactArray message = toContactArray(sample.report, 0);
  EXPECT_EQ(message.pair_count, (std::uint64_t{1} << 33) + 3);
  EXPECT_EQ(message.undecided, 0xFFFFFFFFU);
  EXPECT_EQ(message.rejected_triangles, 0xFFFFFFFFU);
  EXPECT_FALSE(message.complete);
}

TEST(ContactArrayTest, contactsThatTheDetectorLeftOutAreCounted) {
  SampleReport sample;
  sample.result.left_out = 40;
  const ContactArray message = toContactArray(sample.report, 0);
  EXPECT_EQ(message.pairs.size(), 3U);
  EXPECT_EQ(message.pair_count, 43U);
  EXPECT_TRUE(message.truncated);
  EXPECT_FALSE(message.complete);
}

TEST(ContactArrayTest, whateverIsMissingMakesItIncomplete) {
  SampleReport skipped;
  skipped.report.bodies[1].unknown_because = "no transform at 100.5";
  EXPECT_EQ(toContactArray(skipped.report, 0).skipped,
            std::vector<std::string>{"base: no transform at 100.5"});
  EXPECT_FALSE(toContactArray(skipped.report, 0).complete);

  SampleReport rejected;
  rejected.result.counters.rejected = 4;
  EXPECT_EQ(toContactArray(rejected.report, 0).rejected_triangles, 4U);
  EXPECT_FALSE(toContactArray(rejected.report, 0).complete);

  SampleReport cut_off;
  cut_off.result.cutOff("no time");
  EXPECT_FALSE(toContactArray(cut_off.report, 0).complete);
  EXPECT_TRUE(toContactArray(cut_off.report, 0).timed_out);

  SampleReport stopped;
  stopped.result.cutOff("memory_limit_mib");
  EXPECT_FALSE(toContactArray(stopped.report, 0).complete);
  EXPECT_FALSE(toContactArray(stopped.report, 0).timed_out);

  SampleReport lossy;
  lossy.result.guaranteed = false;
  lossy.result.counters.undecided = 2;
  lossy.report.options.predicates = Predicates::kConservative;
  lossy.report.options.overlap = 0.5F;
  lossy.report.options.tolerance_m = 0.25F;
  const ContactArray message = toContactArray(lossy.report, 0);
  EXPECT_FALSE(message.complete);
  EXPECT_FALSE(message.guaranteed);
  EXPECT_EQ(message.undecided, 2U);
  EXPECT_EQ(message.predicates, "conservative");
  EXPECT_EQ(message.overlap, 0.5F);
  EXPECT_EQ(message.tolerance, 0.25F);
}

TEST(ContactArrayTest, withoutADetectionNothingIsClaimed) {
  SampleReport sample;
  sample.report.result = nullptr;
  sample.report.scene = nullptr;
  const ContactArray message = toContactArray(sample.report, 0);
  EXPECT_FALSE(message.complete);
  EXPECT_FALSE(message.guaranteed);
  EXPECT_TRUE(message.pairs.empty());
  EXPECT_EQ(message.pair_count, 0U);
  EXPECT_EQ(message.bodies.size(), 3U);
}

TEST(ContactPatchesTest, carryAllFieldsOfAPatch) {
  const SampleReport sample;
  Patch patch;
  patch.body_a = 0;
  patch.body_b = 2;
  patch.id = 7;
  patch.pair_count = 3;
  patch.triangles_a = {0, 1};
  patch.triangles_b = {2};
  patch.centroid = {1, 2, 3};
  patch.normal = {0, 0, 1};
  patch.normal_spread_rad = std::numeric_limits<double>::quiet_NaN();
  patch.curve_length_m = 0.5;
  patch.area_a_m2 = 2;
  patch.area_b_m2 = 3;
  patch.min_separation_m = -0.25;
  const ContactPatches message = toContactPatches(sample.report, {patch});
  EXPECT_EQ(message.header.stamp, sample.report.header.stamp);
  EXPECT_EQ(message.header.frame_id, "base_link");
  EXPECT_EQ(message.cycle, 7U);
  ASSERT_EQ(message.patches.size(), 1U);
  const ContactPatch& out = message.patches[0];
  EXPECT_EQ(out.stamp, sample.report.header.stamp);
  EXPECT_EQ(out.body_a, "arm/hand");
  EXPECT_EQ(out.body_b, "cloth");
  EXPECT_EQ(out.id, 7U);
  EXPECT_EQ(out.pair_count, 3U);
  EXPECT_EQ(out.triangles_a, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(out.triangles_b, (std::vector<std::uint32_t>{2}));
  EXPECT_EQ(out.centroid.z, 3);
  EXPECT_EQ(out.normal.z, 1);
  EXPECT_TRUE(std::isnan(out.normal_spread));
  EXPECT_EQ(out.curve_length, 0.5);
  EXPECT_EQ(out.area_a, 2);
  EXPECT_EQ(out.area_b, 3);
  EXPECT_EQ(out.min_separation, -0.25);
}

TEST(LinkMeshesTest, surviveTheWayThereAndBack) {
  RobotGeometry geometry;
  geometry.links = {{"a", "box 1 1 1", threeTriangles(), ""},
                    {"b", "package://x/y.stl", {}, "package://x/y.stl: no such file"}};
  const LinkMeshes message = toLinkMeshes(geometry, ros::Time(3));
  EXPECT_EQ(message.header.stamp, ros::Time(3));
  ASSERT_EQ(message.meshes.size(), 2U);
  EXPECT_EQ(message.meshes[0].source, "box 1 1 1");

  const RobotGeometry back = fromLinkMeshes(message);
  ASSERT_EQ(back.links.size(), 2U);
  EXPECT_EQ(back.links[0].link, "a");
  EXPECT_EQ(back.links[0].source, "box 1 1 1");
  EXPECT_EQ(back.links[0].problem, "");
  EXPECT_EQ(back.links[0].mesh.vertices, threeTriangles().vertices);
  EXPECT_EQ(back.links[0].mesh.triangles, threeTriangles().triangles);
  EXPECT_EQ(back.links[1].link, "b");
  EXPECT_NE(back.links[1].problem.find("y.stl: no such file"), std::string::npos);
  EXPECT_TRUE(back.links[1].mesh.vertices.empty());
}

TEST(LinkMeshesTest, aBadMeshCostsOnlyItsLink) {
  LinkMeshes message;
  message.meshes.resize(5);
  const char* const names[] = {"good", "range", "size", "empty", "good"};
  for (std::size_t i = 0; i < 5; ++i) {
    message.meshes[i].link = names[i];
    message.meshes[i].vertices = threeTriangles().vertices;
    message.meshes[i].triangles = threeTriangles().triangles;
  }
  message.meshes[1].triangles[4] = 7;
  message.meshes[2].vertices.pop_back();
  message.meshes[3].triangles.clear();

  const RobotGeometry geometry = fromLinkMeshes(message);
  ASSERT_EQ(geometry.links.size(), 5U);
  EXPECT_EQ(geometry.links[0].problem, "");
  EXPECT_EQ(geometry.links[0].mesh.triangleCount(), 3U);
  for (std::size_t i = 1; i < 5; ++i) {
    EXPECT_NE(geometry.links[i].problem.find(names[i]), std::string::npos) << i;
    EXPECT_TRUE(geometry.links[i].mesh.triangles.empty()) << i;
  }
  EXPECT_NE(geometry.links[4].problem.find("twice"), std::string::npos);
}

}  // namespace
}  // namespace deformable_contact_monitor
