// Ids of patches from cycle to cycle.
#include "core/analysis/patch_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

using Triangles = std::vector<std::uint32_t>;

Patch patchOf(BodyId a, BodyId b, Triangles triangles_a, Triangles triangles_b) {
  Patch patch;
  patch.body_a = a;
  patch.body_b = b;
  patch.triangles_a = std::move(triangles_a);
  patch.triangles_b = std::move(triangles_b);
  return patch;
}

class PatchIds : public ::testing::Test {
 protected:
  PatchIds() : scene_(pairScene(clothGrid(9, 1, 0, 0), clothGrid(9, 1, 0, 0))) {
    scene_.setPairEnabled(0, 0, true);
  }

  // Id by the patch's first triangle of a.
  std::map<std::uint32_t, std::uint32_t> ids(std::vector<Patch> patches) {
    tracker_.assign(scene_, &patches);
    std::map<std::uint32_t, std::uint32_t> ids;
    for (const Patch& patch : patches) ids[patch.triangles_a.front()] = patch.id;
    EXPECT_TRUE(std::is_sorted(patches.begin(), patches.end(), [](const Patch& x, const Patch& y) {
      return std::tie(x.body_a, x.body_b, x.id) < std::tie(y.body_a, y.body_b, y.id);
    }));
    return ids;
  }

  using Ids = std::map<std::uint32_t, std::uint32_t>;

  Scene scene_;
  PatchTracker tracker_;
};

TEST_F(PatchIds, StayWhileATriangleStays) {
  EXPECT_EQ(ids({patchOf(0, 1, {1, 2}, {5}), patchOf(0, 1, {7}, {8})}), (Ids{{1, 1}, {7, 2}}));
  EXPECT_EQ(ids({patchOf(0, 1, {7}, {9}), patchOf(0, 1, {2, 3}, {6})}), (Ids{{7, 2}, {2, 1}}));
  EXPECT_EQ(ids({patchOf(0, 1, {30}, {9})}), (Ids{{30, 2}})) << "a triangle of b is enough";
  EXPECT_EQ(ids({patchOf(0, 1, {9}, {30})}), (Ids{{9, 3}})) << "9 of a is not 9 of b";
}

TEST_F(PatchIds, OfTheLargerPartAfterASplit) {
  EXPECT_EQ(ids({patchOf(0, 1, {1, 2, 3, 4, 5}, {})}), (Ids{{1, 1}}));
  EXPECT_EQ(ids({patchOf(0, 1, {1, 2}, {}), patchOf(0, 1, {3, 4, 5}, {})}), (Ids{{3, 1}, {1, 2}}));
}

TEST_F(PatchIds, OfTheLargerOneAfterAMerge) {
  EXPECT_EQ(ids({patchOf(0, 1, {1, 2}, {}), patchOf(0, 1, {3, 4, 5}, {})}), (Ids{{1, 1}, {3, 2}}));
  EXPECT_EQ(ids({patchOf(0, 1, {1, 2, 3, 4, 5}, {})}), (Ids{{1, 2}}));
  EXPECT_EQ(ids({patchOf(0, 1, {1, 2}, {}), patchOf(0, 1, {3, 4, 5}, {})}), (Ids{{1, 3}, {3, 2}}))
      << "an id does not come again";
}

TEST_F(PatchIds, OfABodyWithItselfOnEitherSide) {
  EXPECT_EQ(ids({patchOf(0, 0, {1}, {2})}), (Ids{{1, 1}}));
  EXPECT_EQ(ids({patchOf(0, 0, {2}, {3})}), (Ids{{2, 1}}));
  EXPECT_EQ(ids({patchOf(0, 1, {2}, {3}), patchOf(0, 0, {3}, {4})}), (Ids{{2, 2}, {3, 1}}))
      << "the same triangles with another body";
}

TEST_F(PatchIds, AreForgottenWithThePatch) {
  EXPECT_EQ(ids({patchOf(0, 1, {1}, {1})}), (Ids{{1, 1}}));
  EXPECT_EQ(ids({}), Ids());
  EXPECT_EQ(ids({patchOf(0, 1, {1}, {1})}), (Ids{{1, 2}}));
}

TEST_F(PatchIds, OfAPairThatIsNotLookedAtStay) {
  EXPECT_EQ(ids({patchOf(0, 1, {1}, {1})}), (Ids{{1, 1}}));
  scene_.setPairEnabled(0, 1, false);
  EXPECT_EQ(ids({patchOf(0, 0, {4}, {5})}), (Ids{{4, 2}}));
  scene_.setPairEnabled(0, 1, true);
  EXPECT_EQ(ids({patchOf(0, 1, {1}, {7})}), (Ids{{1, 1}}));
}

TEST_F(PatchIds, AreForgottenWithTheTriangles) {
  EXPECT_EQ(ids({patchOf(0, 1, {1}, {1})}), (Ids{{1, 1}}));
  const std::vector<float> moved = scene_.body(1).mesh.vertices;
  scene_.setVertices(1, moved.data(), moved.size() / 3);
  EXPECT_EQ(ids({patchOf(0, 1, {1}, {1})}), (Ids{{1, 1}}));
  scene_.setMesh(1, clothGrid(9, 1, 0, 0));
  EXPECT_EQ(ids({patchOf(0, 1, {1}, {1})}), (Ids{{1, 2}}));
  tracker_.forget();
  EXPECT_EQ(ids({patchOf(0, 1, {1}, {1})}), (Ids{{1, 3}}));
}

// Runs of triangles that grow, shrink, split, merge, come and go.
std::vector<Patch> randomPatches(std::vector<bool>* on, std::mt19937* random) {
  for (std::size_t t = 0; t < on->size(); ++t) {
    if ((*random)() % 8 == 0) (*on)[t] = !(*on)[t];
  }
  std::vector<Patch> patches;
  for (std::uint32_t t = 0; t < on->size(); ++t) {
    if (!(*on)[t]) continue;
    if (t == 0 || !(*on)[t - 1]) patches.push_back(patchOf(0, 1, {}, {}));
    patches.back().triangles_a.push_back(t);
    patches.back().triangles_b.push_back(100 + t);
  }
  std::shuffle(patches.begin(), patches.end(), *random);
  return patches;
}

std::size_t common(const Patch& a, const Patch& b) {
  Triangles both;
  std::set_intersection(a.triangles_a.begin(), a.triangles_a.end(), b.triangles_a.begin(),
                        b.triangles_a.end(), std::back_inserter(both));
  return 2 * both.size();  // those of b go with them
}

TEST_F(PatchIds, OverARandomWalkFollowTheLargestOverlap) {
  std::mt19937 random(1);
  std::vector<bool> on(60, false);
  std::vector<Patch> before;
  std::set<std::uint32_t> used;
  int stayed = 0;
  for (int step = 0; step < 2000; ++step) {
    std::vector<Patch> now = randomPatches(&on, &random);
    tracker_.assign(scene_, &now);
    std::set<std::uint32_t> ids;
    for (const Patch& patch : now) {
      ASSERT_NE(patch.id, 0U);
      ASSERT_TRUE(ids.insert(patch.id).second) << "one id, two patches";
      const auto old = std::find_if(before.begin(), before.end(),
                                    [&](const Patch& p) { return p.id == patch.id; });
      if (old == before.end()) {
        ASSERT_TRUE(used.insert(patch.id).second) << "an id came again";
      } else {
        ASSERT_GT(common(*old, patch), 0U);
        ++stayed;
      }
      // Where its id is not that of the one it has most in common with, that one has a patch with
      // which it has as much in common, at least.
      for (const Patch& other : before) {
        const std::size_t mine = common(other, patch);
        const bool larger = mine > (old == before.end() ? 0 : common(*old, patch));
        if (!larger) continue;
        ASSERT_TRUE(std::any_of(now.begin(), now.end(), [&](const Patch& p) {
          return p.id == other.id && common(other, p) >= mine;
        })) << step;
      }
    }
    before = std::move(now);
  }
  EXPECT_GT(stayed, 2000);
}

}  // namespace
}  // namespace deformable_contact_monitor
