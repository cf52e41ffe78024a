// Loops on threads. Blocks are a function of the range alone, so results do not depend on how many
// threads there are.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cstddef>

namespace deformable_contact_monitor {

inline std::size_t blockCount(std::size_t n, std::size_t block_size) {
  return (n + block_size - 1) / block_size;
}

// body(block, begin, end) for each block of [0, n).
template <class Body>
void parallelBlocks(std::size_t n, std::size_t block_size, const Body& body) {
  tbb::parallel_for(std::size_t{0}, blockCount(n, block_size), [&](std::size_t block) {
    body(block, block * block_size, std::min(n, (block + 1) * block_size));
  });
}

// Both, at the same time if there are threads for it.
template <class First, class Second>
void parallelBoth(const First& first, const Second& second) {
  tbb::parallel_invoke(first, second);
}

}  // namespace deformable_contact_monitor
