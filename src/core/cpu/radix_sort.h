// Radix sort of 64-bit keys by their upper halves, in four passes over 8 bits each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/common/parallel.h"

namespace deformable_contact_monitor {

// Sorts by the upper halves, ascending. Keys with equal upper halves keep their order. Once the
// limit is over, the order is unspecified. `scratch` gets as long as `keys`.
inline void sortByUpperHalf(const CycleLimit& limit, std::vector<std::uint64_t>& keys,
                            std::vector<std::uint64_t>& scratch) {
  constexpr int kPasses = 4, kBits = 8;
  constexpr std::size_t kBlock = 1 << 16;
  const auto digit = [](std::uint64_t key, int pass) {
    return static_cast<std::uint8_t>(key >> (32 + kBits * pass));
  };
  std::array<std::array<std::uint32_t, 1 << kBits>, kPasses> place{};
  serialBlocks(limit, keys.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (int pass = 0; pass < kPasses; ++pass) ++place[pass][digit(keys[i], pass)];
    }
  });
  scratch.resize(keys.size());
  for (int pass = 0; pass < kPasses && !limit.wasOver(); ++pass) {
    std::uint32_t total = 0;
    for (std::uint32_t& at : place[pass]) total += std::exchange(at, total);
    serialBlocks(limit, keys.size(), kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        scratch[place[pass][digit(keys[i], pass)]++] = keys[i];
      }
    });
    keys.swap(scratch);
  }
}

}  // namespace deformable_contact_monitor
