// Keys come in the order of their upper halves, equal ones as they stood.
#include "core/cpu/radix_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace deformable_contact_monitor {
namespace {

TEST(RadixSort, IsTheStableSortByUpperHalves) {
  std::mt19937_64 random(1);
  std::vector<std::uint64_t> scratch;
  for (const std::size_t count : {0U, 1U, 2U, 700U, 200000U}) {
    for (const std::uint64_t mask : {~std::uint64_t{0}, std::uint64_t{0xff00ff000000ffffU}}) {
      std::vector<std::uint64_t> keys(count);
      for (std::uint64_t& key : keys) key = random() & mask;
      std::vector<std::uint64_t> expected = keys;
      std::stable_sort(expected.begin(), expected.end(),
                       [](std::uint64_t a, std::uint64_t b) { return a >> 32 < b >> 32; });
      sortByUpperHalf(noLimit(), keys, scratch);
      ASSERT_EQ(expected, keys);
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
