// The CPU's scans and tests in vector lanes tell what the rules that they stand for tell.
#include "core/cpu/interval_scan.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/cpu/sort.h"

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
void expectFound(const ScanCounts& counts, const std::vector<SortedIndex>& found,
                 const ScanRange& range, const Met& met) {
  std::size_t next = 0, overlaps = 0;
  for (std::uint32_t k = range.begin; k < range.end; ++k) {
    if (range.lo[k] > range.most) continue;
    ++overlaps;
    if (!met(k)) continue;
    ASSERT_LT(next, counts.found);
    EXPECT_EQ(k, found[next].value);
    ++next;
  }
  EXPECT_EQ(next, counts.found);
  EXPECT_EQ(overlaps, counts.overlaps);
}

TEST(IntervalScan, FindsWhatTheRuleFinds) {
  std::mt19937 random(3);
  const RandomColumns from(random), to(random);
  std::vector<SortedIndex> found(kCount + kScanChunk);
  std::vector<float> lo;
  for (std::uint32_t i = 0; i < kCount + kScanChunk; ++i) lo.push_back(static_cast<float>(i / 3));
  for (std::uint32_t row = 0; row < kCount; ++row) {
    const std::uint32_t begin = random() % kCount;
    const std::uint32_t end = begin + random() % (kCount - begin + 1);
    const ScanRange range{lo.data(), static_cast<float>(random() % (kCount / 2)), begin, end};
    const PackedColumns a = from.view(), b = to.view();
    expectFound(scanRow(SortedIndex(row), a, range, found.data()), found, range,
                [&](std::uint32_t k) { return intersects(a.box(row), a.box(k)); });
    expectFound(scanRow(SortedIndex(row), a, b, range, found.data()), found, range,
                [&](std::uint32_t k) {
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

TEST(LaneBox, IntersectsWhereTheBoxDoes) {
  std::mt19937 random(5);
  int apart = 0;
  for (int i = 0; i < 20000; ++i) {
    const Aabb a = randomBox(random), b = randomBox(random);
    EXPECT_EQ(intersects(a, b), intersects(LaneBox(a), LaneBox(b)));
    apart += intersects(a, b) ? 0 : 1;
  }
  EXPECT_GT(apart, 1000);
}

TEST(LaneBox, OfATriangleIsItsBoxGrown) {
  std::mt19937 random(6);
  for (int i = 0; i < 1000; ++i) {
    Triangle t;
    for (Vec3f& v : t.v) v = randomBox(random).min;
    const float growth_m = i % 2 == 0 ? 0.0F : 0.3F;
    const LaneBox expected(inflated(boxOf(t), growth_m)), box = boxLanes(t, growth_m);
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(expected.min[k], box.min[k]);
      EXPECT_EQ(expected.max[k], box.max[k]);
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
