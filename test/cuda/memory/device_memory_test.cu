// Tests arrays that lie in one block of memory and grow.
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "cuda/device/stream.cuh"
#include "cuda/memory/device_memory.cuh"
#include "device_test.h"

namespace deformable_contact_monitor {
namespace {

struct TwoArrays : ArrayGroup {
  using ArrayGroup::ArrayGroup;

  DeviceArray<std::uint32_t, Place> entries{*this, &CycleSizes::entries};
  DeviceArray<std::uint64_t, Place, 3> units{*this, &CycleSizes::units, 1};
};

class DeviceMemoryTest : public DeviceTest {
 protected:
  // Numbers from `first` on.
  template <class T>
  void fill(T* to, std::size_t count, T first, CudaStream& stream) {
    std::vector<T> numbers(count);
    std::iota(numbers.begin(), numbers.end(), first);
    EXPECT_EQ(cudaMemcpyAsync(to, numbers.data(), count * sizeof(T), cudaMemcpyHostToDevice,
                              stream.get()),
              cudaSuccess);
    stream.synchronise();
  }
  // `kept` numbers from `first` on, then zeros.
  template <class T>
  void expect(const T* from, std::size_t count, T first, std::size_t kept, CudaStream& stream) {
    std::vector<T> found(count), expected(count);
    std::iota(expected.begin(), expected.begin() + static_cast<std::ptrdiff_t>(kept), first);
    EXPECT_EQ(cudaMemcpyAsync(found.data(), from, count * sizeof(T), cudaMemcpyDeviceToHost,
                              stream.get()),
              cudaSuccess);
    stream.synchronise();
    EXPECT_EQ(found, expected);
  }
};

TEST_F(DeviceMemoryTest, WhatGrowsKeepsItsElementsAndTheNewOnesAreZeros) {
  if (!hasDevice()) return;
  CudaStream stream;
  DeviceMemory memory;
  TwoArrays arrays(memory);
  CycleSizes sizes;
  sizes.entries = 100;
  sizes.units = 9;
  memory.grow(sizes, stream.get());
  EXPECT_EQ(arrays.entries.size(), 100U);
  EXPECT_EQ(arrays.units.size(), 10U);
  expect(arrays.entries.data(), 100, 0U, 0, stream);
  fill(arrays.entries.data(), 100, 1U, stream);
  fill(arrays.units.data(), 30, std::uint64_t{1000}, stream);
  std::size_t kept = 100;
  for (const std::uint32_t entries : {101U, 130U, 131U, 5000U, 5001U, 200000U, 200001U, 200100U}) {
    sizes.entries = entries;
    memory.grow(sizes, stream.get());
    ASSERT_EQ(arrays.entries.size(), entries);
    expect(arrays.entries.data(), entries, 1U, kept, stream);
    expect(arrays.units.data(), 30, std::uint64_t{1000}, 30, stream);
    fill(arrays.entries.data(), entries, 1U, stream);
    kept = entries;
    EXPECT_GE(memory.bytes(), entries * sizeof(std::uint32_t) + 240);
    EXPECT_LE(memory.bytes(), 2 * entries * sizeof(std::uint32_t) + 2048);
  }
}

TEST_F(DeviceMemoryTest, NothingShrinksOrMovesWithoutNeed) {
  if (!hasDevice()) return;
  CudaStream stream;
  DeviceMemory memory;
  TwoArrays arrays(memory);
  CycleSizes sizes;
  sizes.entries = 100;
  memory.grow(sizes, stream.get());
  const auto* const before = arrays.entries.data();
  sizes.entries = 50;
  memory.grow(sizes, stream.get());
  EXPECT_EQ(arrays.entries.size(), 100U);
  EXPECT_EQ(arrays.entries.data(), before);
}

}  // namespace
}  // namespace deformable_contact_monitor
