// Pads: what may touch on ways that are not quite straight is listed too, and marked.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "cgal_oracle.h"
#include "scenes.h"
#include "swept/swept_triangle.h"
#include "swept_expected.h"

namespace deformable_contact_monitor {
namespace {

class SweptPadSoup : public SweptFixture {};

// Pads of its bodies: none, one or all, of very different sizes.
Scene padded(const Scene& scene, std::uint32_t seed) {
  constexpr float kPads[] = {0, 1e-30F, 0.01F, 0.25F, 1, 1e30F, 3e38F};
  Scene out = scene;
  for (BodyId b = 0; b < scene.bodyCount(); ++b) out.setPad(b, kPads[(seed + 3 * b) % 7]);
  return out;
}

TEST_P(SweptPadSoup, AddPairsAndMarkThem) {
  std::size_t found = 0, added = 0;
  for (std::uint32_t seed = 0; seed < 500; ++seed) {
    const Scene scene = randomSweptScene(seed), with_pads = padded(scene, seed);
    const AdjacentPairs adjacent = kBothAdjacent[seed % 2];
    const DetectionResult plain = detector_->detect(scene, timedOptions(adjacent));
    ASSERT_TRUE(plain.within_pad.empty());
    for (const int clusters : clusterCounts()) {
      Options options = timedOptions(adjacent);
      options.clusters = clusters;
      const DetectionResult& result = detector_->detect(with_pads, options);
      ASSERT_TRUE(includes(result.contacts, plain.contacts)) << "seed " << seed;
      ASSERT_EQ(with_pads.anyPad() ? result.contacts.size() : 0, result.within_pad.size());
      ASSERT_EQ(result.contacts.size(), result.first_times.size());
      // Those of the straight ways, and no others, are not marked, and have their times.
      std::vector<TrianglePair> straight;
      for (std::size_t i = 0; i < result.contacts.size(); ++i) {
        const FirstContact& time = result.first_times[i];
        if (with_pads.anyPad() && result.within_pad[i] != 0) {
          ASSERT_EQ(result.within_pad[i], 1);
          ASSERT_TRUE(0 <= time.low && time.low <= 1 && time.high == 1) << "seed " << seed;
          ++added;
          continue;
        }
        const FirstContact& other = plain.first_times.at(straight.size());
        ASSERT_TRUE(time.low <= other.high && other.low <= time.high) << "seed " << seed;
        straight.push_back(result.contacts[i]);
      }
      ASSERT_TRUE(samePairs(plain.contacts, straight)) << "seed " << seed;
      found += straight.size();
    }
  }
  EXPECT_GT(found, 1000U);
  EXPECT_GT(added, 500U);
}

// A pad of a body with itself counts twice, as both triangles are its own; neighbours have none.
TEST_P(SweptPadSoup, OfTwoBodiesAddUp) {
  const Triangle sheet{{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}}};
  const Triangle above{{{1, 1, 1}, {2, 1, 1}, {1, 2, 1}}};
  Scene scene = movingPairScene({{sheet, sheet}}, {{above, above}});
  const auto isListed = [&](float pad_a, float pad_b) {
    scene.setPad(0, pad_a);
    scene.setPad(1, pad_b);
    return !swept(scene).empty();
  };
  EXPECT_FALSE(isListed(0, 0));
  EXPECT_FALSE(isListed(0.25F, 0.25F));
  EXPECT_FALSE(isListed(0.875F, 0));
  EXPECT_TRUE(isListed(0.5F, 0.5F));
  EXPECT_TRUE(isListed(1, 0));
  EXPECT_TRUE(isListed(0, 1));
  EXPECT_TRUE(isListed(0.75F, 0.75F));
  Scene self = movingSelfScene({{sheet, sheet}, {above, above}});
  self.setPad(0, 0.25F);
  EXPECT_TRUE(swept(self).empty());
  self.setPad(0, 0.5F);
  EXPECT_EQ(swept(self).size(), 1U);
  EXPECT_EQ(detector_->detect(self, sweptOptions()).within_pad, std::vector<std::uint8_t>{1});
}

TEST_P(SweptPadSoup, WithoutAnyOfABodyThatTakesPartNothingIsSaid) {
  Scene scene = randomSweptScene(1);
  const BodyId apart = scene.addBody("no pair of its", clothGrid(1, 1, 0, 0));
  scene.setPad(apart, 1);
  const DetectionResult& result = detector_->detect(scene, sweptOptions());
  EXPECT_FALSE(result.contacts.empty());
  EXPECT_TRUE(result.within_pad.empty());
  // Discrete detection ignores the motion bound.
  for (BodyId b = 0; b < scene.bodyCount(); ++b) scene.setPad(b, 1);
  const std::vector<TrianglePair> padded = contacts(scene);
  EXPECT_TRUE(detector_->detect(scene, Options()).within_pad.empty());
  EXPECT_TRUE(samePairs(contacts(laterScene(scene)), padded));
}

// Two bodies in their rigid motions: turned from the one pose to the other about an axis, at an
// even rate, while they move on straight. Points are off the straight way by at most r theta^2 / 8.
struct ScrewMotion {
  Vec3f axis, travel;
  double angle;

  RigidTransform at(double t) const {
    RigidTransform pose;
    const double c = std::cos(t * angle), s = std::sin(t * angle), k = 1 - c;
    const double x = axis.x, y = axis.y, z = axis.z;
    const double turned[9] = {c + x * x * k,     x * y * k - z * s, x * z * k + y * s,
                              y * x * k + z * s, c + y * y * k,     y * z * k - x * s,
                              z * x * k - y * s, z * y * k + x * s, c + z * z * k};
    std::copy(std::begin(turned), std::end(turned), pose.rotation);
    for (int i = 0; i < 3; ++i) pose.translation[i] = t * static_cast<double>(travel[i]);
    return pose;
  }
};

// Nothing that the true motion touches at some time is missed, nor is it touched before the time
// that is told.
TEST_P(SweptPadSoup, HoldContactsOfTheTrueScrewMotion) {
  std::size_t seen = 0, beyond_straight = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const auto unit = [&random] { return static_cast<float>(random() % 2001) / 1000 - 1; };
    Scene scene;
    ScrewMotion motions[2];
    for (ScrewMotion& motion : motions) {
      std::vector<Triangle> triangles;
      double radius = 0;
      for (int i = 0; i < 12; ++i) {
        const Vec3f corner{2 * unit(), 2 * unit(), 2 * unit()};
        Triangle t;
        for (Vec3f& v : t.v) {
          v = corner + Vec3f{unit(), unit(), unit()} * 0.5F;
          radius = std::max(radius, std::sqrt(static_cast<double>(dot(v, v))));
        }
        triangles.push_back(t);
      }
      const Vec3f axis{unit(), unit(), unit()};
      motion.axis = axis * (1 / std::sqrt(dot(axis, axis)));
      motion.travel = Vec3f{unit(), unit(), unit()};
      motion.angle = 0.8 * static_cast<double>(unit());
      const BodyId id = scene.addBody("link", meshOf(triangles));
      scene.setPose(id, motion.at(1));
      scene.setEarlier(id, motion.at(0));
      // And half an ulp for each coordinate and state.
      const double pad = radius * motion.angle * motion.angle / 8 + 4e-6;
      scene.setPad(id, static_cast<float>(pad));
    }
    scene.setPairEnabled(0, 1, true);
    const DetectionResult& result = detector_->detect(scene, timedOptions());
    ASSERT_EQ(result.contacts.size(), result.within_pad.size());
    Scene now = laterScene(scene);
    constexpr int kTimes = 48;
    for (int k = 0; k <= kTimes; ++k) {
      const double t = static_cast<double>(k) / kTimes;
      for (const BodyId b : {0U, 1U}) now.setPose(b, motions[b].at(t));
      for (const TrianglePair& p : oracleContacts(now, AdjacentPairs::kSkip)) {
        const auto place = std::lower_bound(result.contacts.begin(), result.contacts.end(), p);
        ASSERT_TRUE(place != result.contacts.end() && *place == p)
            << "seed " << seed << ", " << p << " at " << t;
        const auto i = static_cast<std::size_t>(place - result.contacts.begin());
        // On the straight ways they may touch later.
        if (result.within_pad[i] != 0) {
          ASSERT_LE(result.first_times[i].low, t) << "seed " << seed << ", " << p;
        }
        ++seen;
        beyond_straight += result.within_pad[i];
      }
    }
  }
  EXPECT_GT(seen, 2000U);
  EXPECT_GT(beyond_straight, 0U);
}

INSTANTIATE_TEST_SUITE_P(, SweptPadSoup, ::testing::ValuesIn(sweptBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
