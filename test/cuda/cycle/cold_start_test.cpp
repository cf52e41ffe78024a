// What is found of a scene from a sample of its triangles, on the host alone.
#include "cuda/cycle/cold_start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

constexpr ClusterCountPolicy kPolicy{500, 8192, 1600, 132};

ColdStart measured(const Scene& scene, Look look, const Options& options = Options()) {
  return SceneMeasurer().measure(scene, SceneShare(), options, kPolicy, look, noLimit());
}

float size(const Vec3f& v) { return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}); }

TEST(SceneMeasurer, ASampleTellsWhatAllTrianglesTell) {
  const Scene scene = selfScene(clothGrid(250, 3, 1, 0.2F));
  const ColdStart sample = measured(scene, Look::kSample), all = measured(scene, Look::kAll);
  EXPECT_EQ(sample.regular, 125000U);
  EXPECT_EQ(all.regular, 125000U);
  EXPECT_EQ(sample.large, 0U);
  EXPECT_EQ(sample.seeds.size(), all.seeds.size());
  EXPECT_EQ(sample.scale.scale, all.scale.scale);
  const Vec3d apart = sample.scale.origin - all.scale.origin;
  EXPECT_LT(dot(apart, apart), 0.05 * 0.05);
  EXPECT_NEAR(sample.size_rule.most_extent, all.size_rule.most_extent, 0.02);
  for (const Vec3f& seed : sample.seeds) EXPECT_LT(size(seed), 1);
}

// Enough to see whether a scene is another one.
TEST(SceneMeasurer, AGlanceTellsScaleAndNumber) {
  const Scene scene = pairScene(clothGrid(200, 1, 3, 0.1F), clothGrid(100, 0.5F, 3, 0.1F));
  const ColdStart glance = measured(scene, Look::kGlance), all = measured(scene, Look::kAll);
  EXPECT_NEAR(static_cast<double>(glance.regular), static_cast<double>(all.regular), 4000);
  EXPECT_LE(glance.scale.scale, 2 * all.scale.scale);
  EXPECT_GE(2 * glance.scale.scale, all.scale.scale);
  const Vec3d apart = glance.scale.origin - all.scale.origin;
  EXPECT_LT(dot(apart, apart) * all.scale.scale * all.scale.scale, 0.1 * 0.1);
}

// Of two bodies of which a part meets: how many triangles that is, from some of the vertices.
TEST(SceneMeasurer, AGlanceTellsHowManyReachIntoTheOther) {
  Scene scene = pairScene(clothGrid(200, 1, 3, 0.1F), clothGrid(100, 1, 3, 0.1F));
  RigidTransform pose;
  pose.translation[0] = 0.75;
  scene.setPose(1, pose);
  const ColdStart glance = measured(scene, Look::kGlance), all = measured(scene, Look::kAll);
  EXPECT_GT(all.regular, 20000U);
  EXPECT_LT(all.regular, 40000U);
  EXPECT_NEAR(static_cast<double>(glance.regular), static_cast<double>(all.regular), 6000);
}

// Some vertex is looked at wherever the others are, also where some are not finite.
TEST(SceneMeasurer, AGlanceLeavesOutWhatIsNotFinite) {
  TriangleMesh cloth = clothGrid(200, 1, 3, 0.1F);
  for (std::size_t i = 0; i < cloth.vertices.size() / 2; i += 3) cloth.vertices[i] = NAN;
  const Scene scene = pairScene(cloth, clothGrid(100, 1, 3, 0.1F));
  const ColdStart glance = measured(scene, Look::kGlance), all = measured(scene, Look::kAll);
  EXPECT_GT(all.regular, 30000U);
  EXPECT_NEAR(static_cast<double>(glance.regular), static_cast<double>(all.regular), 6000);
}

TEST(SceneMeasurer, IsTheSameEachTime) {
  const Scene scene = selfScene(clothGrid(100, 3, 1, 0.2F));
  const ColdStart first = measured(scene, Look::kSample), second = measured(scene, Look::kSample);
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
    const ColdStart start = measured(scene, Look::kSample, options);
    ASSERT_EQ(start.seeds.size(), static_cast<std::size_t>(options.clusters));
    for (std::size_t g = 1; g < start.seeds.size(); ++g) {
      EXPECT_FALSE(start.seeds[g] == start.seeds[g - 1]) << g;
    }
  }
}

TEST(SceneMeasurer, AnOutlierIsLargeWhetherSampledOrNot) {
  TriangleMesh cloth = clothGrid(100, 1, 0, 0.1F);
  cloth.vertices[3 * 5050] = 1e30F;
  for (const Look look : {Look::kGlance, Look::kSample, Look::kAll}) {
    const ColdStart start = measured(selfScene(cloth), look);
    EXPECT_TRUE(start.size_rule.isLarge({{0, 0, 0}, {1e30F, 0, 0}})) << static_cast<int>(look);
    EXPECT_FALSE(start.size_rule.isLarge({{0, 0, 0}, {0.01F, 0.01F, 0.01F}}))
        << static_cast<int>(look);
    EXPECT_GE(start.scale.scale, 0.5) << static_cast<int>(look);
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
  const ColdStart all = measured(selfScene(cloth), Look::kAll),
                  sample = measured(selfScene(cloth), Look::kSample);
  EXPECT_EQ(all.large, 0U) << "too many of them";
  EXPECT_EQ(sample.large, 0U) << "too many of them";
}

TEST(SceneMeasurer, TrianglesOutsideEveryPartnersBoxAreNotCounted) {
  const Scene scene = pairScene(clothGrid(200, 1, 0, 0.1F), clothGrid(20, 0.25F, 0, 0.1F));
  const ColdStart sample = measured(scene, Look::kSample), all = measured(scene, Look::kAll);
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
  const ColdStart sample = measured(scene, Look::kSample, options),
                  all = measured(scene, Look::kAll, options);
  EXPECT_EQ(sample.scale.scale, all.scale.scale);
  EXPECT_GE(sample.scale.scale, 0.5);
  EXPECT_EQ(sample.regular, all.regular);
}

TEST(SceneMeasurer, NothingToLookAtHasOneSeed) {
  Scene scene = pairScene(clothGrid(3, 1, 0, 0), clothGrid(3, 1, 9, 0));
  EXPECT_EQ(measured(scene, Look::kSample).seeds.size(), 1U);
  EXPECT_EQ(measured(scene, Look::kSample).regular, 0U);
  scene.setPairEnabled(0, 1, false);
  EXPECT_EQ(measured(scene, Look::kSample).seeds.size(), 1U);
}

}  // namespace
}  // namespace deformable_contact_monitor
