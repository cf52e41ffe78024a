// Pads: what comes within them is listed and marked, and nothing is lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/common/posed_body.h"
#include "core/predicates/narrow_phase.h"
#include "moving_meshes.h"
#include "scenes.h"
#include "swept/swept_scenes.h"
#include "swept_suite.h"

namespace deformable_contact_monitor {
namespace {

class SweptPads : public DetectorSuite {
 protected:
  DetectionResult detect(const Scene& scene, const Options& options = sweptOptions()) {
    return detector_->detect(scene, options);
  }
};

Scene shakenCloths(unsigned seed) {
  Scene scene = pairScene(clothGrid(14, 1, 0, 0.1F), clothGrid(12, 1, 0.08F, -0.1F));
  scene.setPairEnabled(0, 0, true);
  scene.setEarlier(0, RigidTransform(), shaken(scene.body(0).mesh, 0.02F, seed));
  scene.setEarlier(1, translationBy(0.02, 0, 0.03), shaken(scene.body(1).mesh, 0.01F, seed + 1));
  return scene;
}

Triangle at(const MovingTriangle& t, double s) {
  Triangle now;
  for (int i = 0; i < 3; ++i) {
    now.v[i] = toFloat(toDouble(t.from.v[i]) * (1 - s) + toDouble(t.to.v[i]) * s);
  }
  return now;
}

MovingTriangle movingOf(const Scene& before, const Scene& scene, BodyId body, std::uint32_t t) {
  return {PosedBody(before.body(body)).triangle(t), PosedBody(scene.body(body)).triangle(t)};
}

TEST_P(SweptPads, ContactsWithoutThemAreThereAndNotMarked) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    Scene scene = shakenCloths(seed);
    Options options = sweptOptions();
    options.first_times = true;
    const DetectionResult without = detect(scene, options);
    ASSERT_GT(without.contacts.size(), 50U);
    EXPECT_TRUE(without.within_pad.empty());
    scene.setPad(0, 0.003F);
    scene.setPad(1, 0.002F);
    const DetectionResult with = detect(scene, options);
    ASSERT_EQ(with.contacts.size(), with.within_pad.size());
    ASSERT_EQ(with.contacts.size(), with.first_times.size());
    EXPECT_TRUE(isOrdered(with.contacts));
    std::vector<TrianglePair> not_marked;
    for (std::size_t i = 0; i < with.contacts.size(); ++i) {
      if (with.within_pad[i] == 0) {
        const std::size_t place = not_marked.size();
        ASSERT_LT(place, without.first_times.size());
        EXPECT_EQ(without.first_times[place].low, with.first_times[i].low);
        EXPECT_EQ(without.first_times[place].high, with.first_times[i].high);
        not_marked.push_back(with.contacts[i]);
      } else {
        EXPECT_EQ(1, with.first_times[i].high);
      }
    }
    EXPECT_TRUE(samePairs(without.contacts, not_marked));
    EXPECT_GT(with.contacts.size(), without.contacts.size());
  }
}

// Pairs that are nearer than the two pads together at some time, but share no vertex.
TEST_P(SweptPads, NothingNearerThanTheirSumIsLost) {
  for (unsigned seed = 10; seed < 12; ++seed) {
    Scene scene = shakenCloths(seed);
    scene.setPad(0, 0.004F);
    scene.setPad(1, 0.002F);
    const Scene before = earlierScene(scene);
    Options options = sweptOptions(AdjacentPairs::kSkip);
    for (const int clusters : {0, 1, 50}) {
      options.clusters = clusters;
      const std::vector<TrianglePair> found = contacts(scene, options);
      std::size_t near = 0;
      for (const BodyId b : {BodyId{0}, BodyId{1}}) {
        const float pads_m = scene.body(0).pad_m + scene.body(b).pad_m;
        for (std::uint32_t i = 0; i < scene.body(0).mesh.triangleCount(); ++i) {
          const MovingTriangle first = movingOf(before, scene, 0, i);
          for (std::uint32_t j = b == 0 ? i + 1 : 0; j < scene.body(b).mesh.triangleCount(); ++j) {
            const MovingTriangle second = movingOf(before, scene, b, j);
            if (b == 0 && sharedTrajectories(first, second).any) continue;
            bool is_near = false;
            for (int s = 0; s <= 4 && !is_near; ++s) {
              is_near =
                  nearVerdict(at(first, s / 4.0), at(second, s / 4.0), 0.99F * pads_m).contact;
            }
            if (!is_near) continue;
            ++near;
            EXPECT_TRUE(std::binary_search(found.begin(), found.end(), TrianglePair(0, i, b, j)))
                << i << " " << j;
          }
        }
      }
      EXPECT_GT(near, 100U);
    }
  }
}

// Neighbours in a mesh are always near: pads are not for them.
TEST_P(SweptPads, DoNotApplyToNeighbours) {
  Scene scene = selfScene(clothGrid(1, 1, 0, 0));
  scene.setEarlier(0, translationBy(0, 0, 1));
  scene.setPad(0, 0.01F);
  const DetectionResult result = detect(scene);
  EXPECT_TRUE(result.contacts.empty());
  EXPECT_TRUE(result.within_pad.empty());
}

TEST_P(SweptPads, MarginsPlayNoPart) {
  Scene scene = shakenCloths(20);
  const auto expected = contacts(scene, sweptOptions());
  scene.setMargin(0, 0.05F);
  const DetectionResult result = detect(scene);
  EXPECT_TRUE(samePairs(expected, result.contacts));
  EXPECT_TRUE(result.separations_m.empty());
}

INSTANTIATE_TEST_SUITE_P(, SweptPads, ::testing::ValuesIn(sweptBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
