// The CPU's scans and tests in vector lanes tell what the rules that they stand for tell.
#include "core/cpu/interval_scan.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/cpu/lane_box.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kCount = 300;

// Packed boxes of a few sizes, by place; the arrays are longer, as scans may read on.
struct RandomColumns {
  std::vector<std::uint32_t> lo, hi;

  explicit RandomColumns(std::mt19937& random) {
    for (std::uint32_t i = 0; i < kCount + kScanChunk; ++i) {
      const std::uint32_t x = random() % 32000, y = random() % 32000;
      lo.push_back(x | y << 16);
      hi.push_back(lo.back() + (random() % 768 | (random() % 768) << 16));
    }
    lo[5] = 0;
    hi[5] = 0x7fff7fff;
  }
  PackedColumns view() const { return {lo.data(), hi.data()}; }
};

template <class Met>
void expectPairs(std::uint32_t row, const std::vector<BoxPair>& pairs, std::size_t count,
                 std::uint32_t begin, std::uint32_t end, const Met& met) {
  std::size_t next = 0;
  for (std::uint32_t k = begin; k < end; ++k) {
    if (!met(k)) continue;
    ASSERT_LT(next, count);
    EXPECT_EQ(row, pairs[next].a.value);
    EXPECT_EQ(k, pairs[next].b.value);
    ++next;
  }
  EXPECT_EQ(next, count);
}

TEST(IntervalScan, FindsWhatTheRuleFinds) {
  std::mt19937 random(3);
  const RandomColumns from(random), to(random);
  std::vector<BoxPair> pairs(kCount + kScanChunk);
  for (std::uint32_t row = 0; row < kCount; ++row) {
    const std::uint32_t begin = random() % kCount;
    const std::uint32_t end = begin + random() % (kCount - begin + 1);
    const PackedColumns a = from.view(), b = to.view();
    const std::size_t still = scanRow(SortedIndex(row), a, begin, end, pairs.data());
    expectPairs(row, pairs, still, begin, end,
                [&](std::uint32_t k) { return intersects(a.box(row), a.box(k)); });
    const std::size_t moving = scanRow(SortedIndex(row), a, b, begin, end, pairs.data());
    expectPairs(row, pairs, moving, begin, end, [&](std::uint32_t k) {
      return intersects(MovingPackedBox{a.box(row), b.box(row)},
                        MovingPackedBox{a.box(k), b.box(k)});
    });
  }
}

// Few coordinates, so that boxes touch.
Aabb randomBox(std::mt19937& random) {
  const auto any = [&random] { return static_cast<float>(random() % 7); };
  Aabb box;
  for (int i = 0; i < 2; ++i) box.include(Vec3f{any(), any(), any()});
  return box;
}

TEST(LaneBox, IntersectsWhereTheMovingBoxDoes) {
  std::mt19937 random(4);
  int apart = 0;
  for (int i = 0; i < 20000; ++i) {
    MovingBox a{randomBox(random), randomBox(random)}, b{randomBox(random), randomBox(random)};
    if (i % 100 == 0) a.to.max.x = INFINITY;
    if (i % 100 == 1) b.from.min.y = NAN;
    EXPECT_EQ(intersects(a, b), intersects(LaneMovingBox(a), LaneMovingBox(b)));
    EXPECT_EQ(intersects(a, b), intersects(LaneMovingBox(b), LaneMovingBox(a)));
    apart += intersects(a, b) ? 0 : 1;
  }
  EXPECT_GT(apart, 1000);
}

}  // namespace
}  // namespace deformable_contact_monitor
