// Tests how buffers grow, on the host alone.
#include <gtest/gtest.h>

#include "cuda/device/cuda_error.h"
#include "cuda/memory/cycle_sizes.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint64_t kAmple = std::uint64_t{1} << 40;

TEST(CycleSizes, WhatFitsDoesNotGrow) {
  CycleSizes sizes;
  sizes.triangles = 10000;
  sizes.tiles = 400;
  sizes.prepare(9000, 20, kAmple);
  EXPECT_EQ(sizes.samples, 1024U);
  EXPECT_GE(sizes.entries, 1600U);
  CycleCounters counters{};
  counters.bins_wanted = sizes.entries;
  counters.list_words = sizes.list_words;
  counters.units = sizes.units;
  counters.tile_pairs = sizes.tile_pairs;
  counters.dense_pairs = sizes.dense_pairs;
  counters.candidates = sizes.candidates;
  counters.contacts = sizes.contacts;
  EXPECT_FALSE(sizes.growFor(counters, kAmple));
}

TEST(CycleSizes, EachGrowsByItsOwnNeed) {
  CycleSizes sizes;
  sizes.triangles = 1000;
  sizes.prepare(1000, 2, kAmple);
  const CycleSizes before = sizes;
  CycleCounters counters{};
  counters.units = before.units + 1;
  EXPECT_TRUE(sizes.growFor(counters, kAmple));
  EXPECT_GT(sizes.units, before.units);
  EXPECT_EQ(sizes.entries, before.entries);
  EXPECT_EQ(sizes.candidates, before.candidates);
  counters.candidates = 3000000;
  counters.contacts = 5 * before.contacts;
  counters.list_words = 4000;
  counters.bins_wanted = 100000;
  counters.tile_pairs = 200000;
  counters.dense_pairs = 100000;
  EXPECT_TRUE(sizes.growFor(counters, kAmple));
  EXPECT_GE(sizes.tile_pairs, 200000U);
  EXPECT_GE(sizes.dense_pairs, 100000U);
  EXPECT_GE(sizes.candidates, 3000000U);
  EXPECT_GE(sizes.contacts, 5 * before.contacts);
  EXPECT_GE(sizes.list_words, 4000U);
  EXPECT_GE(sizes.entries, 100000U);
  EXPECT_FALSE(sizes.growFor(counters, kAmple));
}

TEST(CycleSizes, WhatIsNearlyFullGrowsInAdvance) {
  CycleSizes sizes;
  sizes.prepare(9000, 20, kAmple);
  const CycleSizes before = sizes;
  CycleCounters counters{};
  counters.units = before.units / 2;
  counters.contacts = before.contacts - before.contacts / 10;
  sizes.growInAdvance(counters, kAmple);
  EXPECT_EQ(sizes.units, before.units);
  EXPECT_EQ(sizes.entries, before.entries);
  EXPECT_EQ(sizes.contacts, 2 * counters.contacts);
  const CycleSizes grown = sizes;
  sizes.growInAdvance(counters, kAmple);
  EXPECT_EQ(sizes.contacts, grown.contacts) << "once is enough";
}

TEST(CycleSizes, GrowthInAdvanceKeepsTheLimit) {
  constexpr std::uint64_t kLimit = 1 << 20;
  CycleSizes sizes;
  sizes.prepare(1000000, 2000, kLimit);
  CycleCounters counters{};
  counters.candidates = sizes.candidates;
  counters.contacts = sizes.contacts;
  const CycleSizes before = sizes;
  sizes.growInAdvance(counters, kLimit);
  EXPECT_EQ(sizes.candidates, before.candidates);
  EXPECT_EQ(sizes.contacts, before.contacts);
}

// A scene that grows by a hundredth each time.
TEST(CycleSizes, OfAGrowingSceneGrowRarely) {
  CycleSizes sizes;
  std::uint32_t changes = 0;
  for (double n = 1000; n < 20000; n *= 1.01) {
    const CycleSizes before = sizes;
    const auto triangles = static_cast<std::uint32_t>(n);
    CycleSizes::raise(sizes.triangles, triangles);
    CycleSizes::raise(sizes.tiles, triangles / 32 + 1);
    sizes.prepare(triangles, 20, kAmple);
    EXPECT_GE(sizes.triangles, triangles);
    EXPECT_GE(sizes.entries, triangles / 8);
    changes += sizes.triangles != before.triangles || sizes.entries != before.entries;
  }
  EXPECT_LE(changes, 20U);
}

TEST(CycleSizes, CandidatesAndContactsStopAtTheLimit) {
  constexpr std::uint64_t kLimit = 1 << 20;
  CycleSizes sizes;
  sizes.triangles = 1000000;
  sizes.prepare(1000000, 2000, kLimit);
  EXPECT_LE(sizes.candidates * std::uint64_t{16}, kLimit / 2);
  EXPECT_LE(sizes.contacts * std::uint64_t{24}, kLimit / 2);
  CycleCounters counters{};
  counters.candidates = std::uint64_t{1} << 36;  // more than 32 bits count
  counters.contacts = std::uint64_t{1} << 35;
  while (sizes.growFor(counters, kLimit)) {
  }
  EXPECT_LE(sizes.candidates * std::uint64_t{16}, kLimit / 2);
  EXPECT_GT(sizes.candidates * std::uint64_t{16}, kLimit / 2 - 32);
  EXPECT_LE(sizes.contacts * std::uint64_t{24}, kLimit / 2);
  EXPECT_GT(sizes.contacts, 0U);
}

TEST(CycleSizes, WithHardlyAnyMemoryThereIsAPlaceEach) {
  CycleSizes sizes;
  sizes.triangles = 100;
  sizes.prepare(100, 1, 1);
  EXPECT_EQ(sizes.candidates, 1U);
  EXPECT_EQ(sizes.contacts, 1U);
}

TEST(CycleSizes, MoreEntriesThanTheirBitsAreRejected) {
  CycleSizes sizes;
  CycleCounters counters{};
  counters.bins_wanted = 1U << 29;
  try {
    sizes.growFor(counters, kAmple);
    ADD_FAILURE() << "not refused";
  } catch (const CudaError& error) {
    EXPECT_EQ(error.fault(), BackendFault::kSceneTooLarge) << "no fault of the device";
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
