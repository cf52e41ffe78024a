// The CPU's filters in vector lanes leave the same candidates as the rule they stand for.
#include "core/cpu/filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// Tests ids too, whose sign bit is a mark. The result is the same on every processor.
TEST(LaneBits, AreSigns) {
  constexpr int kMost = std::numeric_limits<int>::max(), kLeast = std::numeric_limits<int>::min();
  EXPECT_EQ(0, laneBits(IntLanes{15, 15, 0, kMost}));
  EXPECT_EQ(15, laneBits(IntLanes{-1, -1, -1, -1}));
  EXPECT_EQ(15, laneBits(IntLanes{kLeast, -16, kLeast, -16}));
  for (int i = 0; i < 4; ++i) {
    IntLanes lanes = {15, 15, 15, 15};
    lanes[i] = kLeast;
    EXPECT_EQ(1 << i, laneBits(lanes));
  }
}

// Few distinct corners, so that many pairs share some, and many vertices lie in another's plane.
std::vector<Triangle> randomTriangles(unsigned seed) {
  std::mt19937 random(seed);
  const auto coordinate = [&random] { return static_cast<float>(random() % 4); };
  std::vector<Triangle> triangles(60);
  for (Triangle& t : triangles) {
    for (Vec3f& v : t.v) v = {coordinate(), coordinate(), coordinate()};
  }
  return triangles;
}

using Known = std::tuple<std::uint32_t, std::uint32_t, std::vector<int>>;

// The parts of a candidate that are compared.
Known known(const Candidate<Triangle>& c) {
  std::vector<int> facts;
  for (int i = 0; i < 3; ++i) {
    facts.insert(facts.end(), {c.facts.shared.in_a[i], c.facts.shared.in_b[i]});
    // Sides are told of pairs that share nothing.
    if (!c.facts.shared.any) facts.insert(facts.end(), {c.facts.sides.a[i], c.facts.sides.b[i]});
  }
  facts.insert(facts.end(), {c.facts.shared.any, c.facts.margin_m > 0});
  return {c.a.value, c.b.value, facts};
}

std::vector<Known> sorted(const std::vector<Candidate<Triangle>>& candidates) {
  std::vector<Known> all;
  for (const Candidate<Triangle>& c : candidates) all.push_back(known(c));
  std::sort(all.begin(), all.end());
  return all;
}

// Takes those for candidates again that float32 settled; none of them otherwise than the verdict.
void addSettled(const WorkingSet& set, const std::vector<Candidate<Triangle>>& by_rule,
                FilteredPairs<Triangle>& filtered) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, bool>
      crossings;  // settled pairs: do they meet?
  for (const auto& [a, b] : filtered.meeting) crossings[{a.value, b.value}] = true;
  const std::vector<Known> open = sorted(filtered.candidates);
  for (const Candidate<Triangle>& c : by_rule) {
    if (std::binary_search(open.begin(), open.end(), known(c))) continue;
    PredicateState state;
    const bool meet = candidateVerdict(set.posed(c.a), set.posed(c.b), c.facts, state).contact;
    EXPECT_EQ(meet, crossings.count({c.a.value, c.b.value}) > 0) << c.a.value << " " << c.b.value;
    filtered.candidates.push_back(c);
    if (!meet) --filtered.apart;
  }
}

class ScreenTest : public testing::TestWithParam<std::tuple<AdjacentPairs, float>> {};

TEST_P(ScreenTest, LeavesWhatTheRuleLeaves) {
  std::size_t sharing = 0, separate = 0, dropped = 0, settled = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene scene = selfScene(meshOf(randomTriangles(seed)));
    Options options;
    std::tie(options.adjacent, std::ignore) = GetParam();
    scene.setMargin(0, std::get<1>(GetParam()));
    WorkingSetBuilder builder;
    WorkingSet set;
    Counters counters;
    builder.build(scene, Options(), set, counters);
    const SizeSplit split;
    const ClusterAssignment<Triangle> assignment;
    const BodyGroups groups(scene);
    const std::vector<float> slack = scaledSlacks(scene, Options(), split.scale);
    const CycleInput<Triangle> input{scene, set, split, assignment, groups, slack, options};
    FilterBuffers<Triangle> buffers;
    PairFilter<Triangle> filter(input, buffers);

    std::vector<PreparedTriangle<Triangle>> triangles;
    for (std::uint32_t i = 0; i < set.size(); ++i) {
      const TriangleIndex t(i);
      triangles.emplace_back(set.posed(t), set.vertexIds(t), t, set.bodyOf(t));
    }
    std::vector<BoxPair> pairs;
    std::vector<Candidate<Triangle>> by_rule, one_by_one;
    FilteredPairs<Triangle> all_at_once;
    for (std::uint32_t i = 0; i < set.size(); ++i) {
      for (std::uint32_t j = i + 1; j < set.size(); ++j) {
        pairs.push_back({SortedIndex(i), SortedIndex(j)});
        const TriangleIndex a(i), b(j);
        filter.filter(triangles[i], triangles[j], one_by_one);
        PairFacts facts;
        facts.shared = sharedVertices(set.posed(a), set.posed(b));
        if (facts.shared.any && options.adjacent == AdjacentPairs::kSkip) continue;
        if (!facts.shared.any) facts.margin_m = scene.body(0).margin_m;
        const bool left = isCandidate(set.posed(a), set.posed(b), facts);
        if (left) by_rule.push_back({a, b, facts});
        (left ? (facts.shared.any ? sharing : separate) : dropped) += 1;
      }
    }
    filter.filter(triangles, pairs.data(), pairs.size(), all_at_once);
    EXPECT_TRUE(sorted(by_rule) == sorted(one_by_one)) << "seed " << seed;
    settled += all_at_once.apart + all_at_once.meeting.size();
    addSettled(set, by_rule, all_at_once);
    EXPECT_TRUE(sorted(by_rule) == sorted(all_at_once.candidates)) << "seed " << seed;
    EXPECT_EQ(all_at_once.apart, 0U) << "seed " << seed;
  }
  EXPECT_EQ(std::get<1>(GetParam()) == 0, settled > 1000) << settled;
  EXPECT_EQ(std::get<0>(GetParam()) == AdjacentPairs::kBeyondShared, sharing > 1000) << sharing;
  EXPECT_GT(separate, 1000U);
  if (std::get<0>(GetParam()) == AdjacentPairs::kBeyondShared || std::get<1>(GetParam()) == 0) {
    EXPECT_GT(dropped, 1000U);
  }
}

INSTANTIATE_TEST_SUITE_P(, ScreenTest,
                         testing::Combine(testing::Values(AdjacentPairs::kSkip,
                                                          AdjacentPairs::kBeyondShared),
                                          testing::Values(0.0F, 0.5F)));

}  // namespace
}  // namespace deformable_contact_monitor
