// Tests what is found of a scene from a sample of its triangles, on the host alone.
#include "cuda/cycle/cold_start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

constexpr ClusterCountPolicy kPolicy{500, 8192, 1600, 132};

ColdStart measured(const Scene& scene, Inspection inspection, const Options& options = Options()) {
  return SceneMeasurer().measure(scene, ScenePartition(), options, kPolicy, inspection, noLimit());
}

float size(const Vec3f& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

TEST(SceneMeasurer, ASampleTellsWhatAllTrianglesTell) {
  const Scene scene = selfScene(clothGrid(250, 3, 1, 0.2F));
  const ColdStart sample = measured(scene, Inspection::kSample),
                  all = measured(scene, Inspection::kAll);
  EXPECT_EQ(sample.regular, 125000U);
  EXPECT_EQ(all.regular, 125000U);
  EXPECT_EQ(sample.oversized, 0U);
  EXPECT_EQ(sample.seeds.size(), all.seeds.size());
  EXPECT_EQ(sample.scale.scale, all.scale.scale);
  const Vec3d apart = sample.scale.origin - all.scale.origin;
  EXPECT_LT(dot(apart, apart), 0.05 * 0.05);
  EXPECT_NEAR(sample.size_rule.most_extent, all.size_rule.most_extent, 0.02);
  for (const Vec3f& seed : sample.seeds) EXPECT_LT(size(seed), 1);
}

// Enough to see whether a scene is another one.
TEST(SceneMeasurer, ABriefInspectionFindsScaleAndNumber) {
  const Scene scene = pairScene(clothGrid(200, 1, 3, 0.1F), clothGrid(100, 0.5F, 3, 0.1F));
  const ColdStart brief = measured(scene, Inspection::kBrief),
                  all = measured(scene, Inspection::kAll);
  EXPECT_NEAR(static_cast<double>(brief.regular), static_cast<double>(all.regular), 4000);
  EXPECT_LE(brief.scale.scale, 2 * all.scale.scale);
  EXPECT_GE(2 * brief.scale.scale, all.scale.scale);
  const Vec3d apart = brief.scale.origin - all.scale.origin;
  EXPECT_LT(dot(apart, apart) * all.scale.scale * all.scale.scale, 0.1 * 0.1);
}

// Counts, from some of the vertices, the triangles of two bodies of which a part meets.
TEST(SceneMeasurer, ABriefInspectionFindsHowManyReachIntoTheOther) {
  Scene scene = pairScene(clothGrid(200, 1, 3, 0.1F), clothGrid(100, 1, 3, 0.1F));
  RigidTransform pose;
  pose.translation[0] = 0.75;
  scene.setPose(1, pose);
  const ColdStart brief = measured(scene, Inspection::kBrief),
                  all = measured(scene, Inspection::kAll);
  EXPECT_GT(all.regular, 20000U);
  EXPECT_LT(all.regular, 40000U);
  EXPECT_NEAR(static_cast<double>(brief.regular), static_cast<double>(all.regular), 6000);
}

// Some vertex is looked at wherever the others are, also where some are not finite.
TEST(SceneMeasurer, ABriefInspectionSkipsWhatIsNotFinite) {
  TriangleMesh cloth = clothGrid(200, 1, 3, 0.1F);
  for (std::size_t i = 0; i < cloth.vertices.size() / 2; i += 3) cloth.vertices[i] = NAN;
  const Scene scene = pairScene(cloth, clothGrid(100, 1, 3, 0.1F));
  const ColdStart brief = measured(scene, Inspection::kBrief),
                  all = measured(scene, Inspection::kAll);
  EXPECT_GT(all.regular, 30000U);
  EXPECT_NEAR(static_cast<double>(brief.regular), static_cast<double>(all.regular), 6000);
}

TEST(SceneMeasurer, IsTheSameEachTime) {
  const Scene scene = selfScene(clothGrid(100, 3, 1, 0.2F));
  const ColdStart first = measured(scene, Inspection::kSample),
                  second = measured(scene, Inspection::kSample);
  EXPECT_EQ(first.scale.scale, second.scale.scale);
  ASSERT_EQ(first.seeds.size(), second.seeds.size());
  for (std::size_t g = 0; g < first.seeds.size(); ++g) {
    EXPECT_TRUE(first.seeds[g] == second.seeds[g]);
  }
}

// Each stands for another part of the scene: also where few of its triangles can be in contact.
TEST(SceneMeasurer, NoSeedComesTwice) {
  Options options;
  for (const float side : {1.0F, 0.02F}) {
    options.clusters = side == 1 ? 2000 : 400;
    Scene scene = pairScene(clothGrid(120, 1, 0, 0.1F), clothGrid(30, side, 0, 0.1F));
    const ColdStart start = measured(scene, Inspection::kSample, options);
    ASSERT_EQ(start.seeds.size(), static_cast<std::size_t>(options.clusters));
    for (std::size_t g = 1; g < start.seeds.size(); ++g) {
      EXPECT_FALSE(start.seeds[g] == start.seeds[g - 1]) << g;
    }
  }
}

TEST(SceneMeasurer, AnOutlierIsLargeWhetherSampledOrNot) {
  TriangleMesh cloth = clothGrid(100, 1, 0, 0.1F);
  cloth.vertices[3 * 5050] = 1e30F;
  for (const Inspection inspection : {Inspection::kBrief, Inspection::kSample, Inspection::kAll}) {
    const ColdStart start = measured(selfScene(cloth), inspection);
    EXPECT_TRUE(SizeBounds(start.size_rule).isOversized({{0, 0, 0}, {1e30F, 0, 0}}))
        << static_cast<int>(inspection);
    EXPECT_FALSE(SizeBounds(start.size_rule).isOversized({{0, 0, 0}, {0.01F, 0.01F, 0.01F}}))
        << static_cast<int>(inspection);
    for (const float far : {-1e6F, 1e6F}) {
      for (const Vec3f& at : {Vec3f{far, 0, 0}, Vec3f{0, far, 0}, Vec3f{0, 0, far}}) {
        EXPECT_TRUE(SizeBounds(start.size_rule).isOversized({at, at}));
      }
    }
    EXPECT_GE(start.scale.scale, 0.5) << static_cast<int>(inspection);
  }
}

// As many large ones as the bound allows for all, not for the sample.
TEST(SceneMeasurer, LargeTrianglesAreFewOfAll) {
  TriangleMesh cloth = clothGrid(150, 1, 0, 0.1F);
  for (std::uint32_t t = 0; t < 45000; t += 40) {  // 2.5 % of them
    cloth.triangles[3 * t] = 0;
    cloth.triangles[3 * t + 1] = 150;
    cloth.triangles[3 * t + 2] = static_cast<std::uint32_t>(cloth.vertexCount()) - 1;
  }
  const ColdStart all = measured(selfScene(cloth), Inspection::kAll),
                  sample = measured(selfScene(cloth), Inspection::kSample);
  EXPECT_EQ(all.oversized, 0U) << "too many of them";
  EXPECT_EQ(sample.oversized, 0U) << "too many of them";
}

TEST(SceneMeasurer, TrianglesOutsideEveryPartnersBoxAreNotCounted) {
  const Scene scene = pairScene(clothGrid(200, 1, 0, 0.1F), clothGrid(20, 0.25F, 0, 0.1F));
  const ColdStart sample = measured(scene, Inspection::kSample),
                  all = measured(scene, Inspection::kAll);
  EXPECT_LT(all.regular, 8000U);
  EXPECT_NEAR(static_cast<double>(sample.regular), static_cast<double>(all.regular), 800);
}

TEST(SceneMeasurer, StepsAreMeasuredWithoutTheCommonMotion) {
  Scene scene = selfScene(clothGrid(100, 1, 0, 0.1F));
  RigidTransform before;
  before.translation[0] = -50;
  scene.setEarlier(0, before);
  Options options;
  options.motion = Motion::kSwept;
  const ColdStart sample = measured(scene, Inspection::kSample, options),
                  all = measured(scene, Inspection::kAll, options);
  EXPECT_EQ(sample.scale.scale, all.scale.scale);
  EXPECT_GE(sample.scale.scale, 0.5);
  EXPECT_EQ(sample.regular, all.regular);
}

TEST(SceneMeasurer, AnEmptySceneHasOneSeed) {
  Scene scene = pairScene(clothGrid(3, 1, 0, 0), clothGrid(3, 1, 9, 0));
  EXPECT_EQ(measured(scene, Inspection::kSample).seeds.size(), 1U);
  EXPECT_EQ(measured(scene, Inspection::kSample).regular, 0U);
  scene.setPairEnabled(0, 1, false);
  EXPECT_EQ(measured(scene, Inspection::kSample).seeds.size(), 1U);
}

}  // namespace
}  // namespace deformable_contact_monitor
