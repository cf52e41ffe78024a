// Memory of the device that is given back while work of its stream is still to come.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "cuda/device/stream.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_pool.cuh"
#include "device_test.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kWords = std::size_t{1} << 20;
constexpr std::uint32_t kLate = 0x11111111, kByte = 0x22, kOwn = 0x22222222;

// Once that long is over.
__global__ void fillLate(std::uint32_t* words, std::size_t count, unsigned long long nanoseconds) {
  unsigned long long begin = 0, now = 0;
  asm volatile("mov.u64 %0, %globaltimer;" : "=l"(begin));
  do {
    asm volatile("mov.u64 %0, %globaltimer;" : "=l"(now));
  } while (now - begin < nanoseconds);
  for (std::size_t i = blockIdx.x * blockDim.x + threadIdx.x; i < count;
       i += std::size_t{gridDim.x} * blockDim.x) {
    words[i] = kLate;
  }
}

class DevicePoolTest : public DeviceTest {
 protected:
  // Returns the contents once the stream is done.
  static std::vector<std::uint32_t> contentOf(const DeviceBuffer<std::uint32_t>& buffer,
                                              CudaStream& stream) {
    std::vector<std::uint32_t> words(buffer.size());
    buffer.download(words.data(), words.size(), stream.get());
    stream.synchronise();
    return words;
  }
};

// Somebody else's buffers, as many as would take the place of what was given back, hold what was
// written to them last.
TEST_F(DevicePoolTest, WhatAKernelStillWritesIsNobodyElses) {
  if (!hasDevice()) return;
  CudaStream writer, other;
  {
    DeviceBuffer<std::uint32_t> grows(kWords, writer.get());
    fillLate<<<32, 256, 0, writer.get()>>>(grows.data(), kWords, 50'000'000);
    EXPECT_TRUE(grows.grow(2 * kWords, writer.get()));
    fillLate<<<32, 256, 0, writer.get()>>>(grows.data(), 2 * kWords, 50'000'000);
  }
  EXPECT_FALSE(writer.isIdle()) << "nothing was left to harm anybody";
  std::vector<std::unique_ptr<DeviceBuffer<std::uint32_t>>> others;
  for (int i = 0; i < 32; ++i) {
    others.push_back(std::make_unique<DeviceBuffer<std::uint32_t>>(kWords, other.get()));
    ASSERT_EQ(cudaMemsetAsync(others[i]->data(), kByte, others[i]->bytes(), other.get()),
              cudaSuccess);
  }
  writer.synchronise();
  for (const auto& buffer : others) {
    EXPECT_EQ(contentOf(*buffer, other), std::vector<std::uint32_t>(kWords, kOwn));
  }
}

TEST_F(DevicePoolTest, MoreThanThereIsIsRefused) {
  if (!hasDevice()) return;
  CudaStream stream;
  std::size_t free = 0, all = 0;
  ASSERT_EQ(cudaMemGetInfo(&free, &all), cudaSuccess);
  DeviceBuffer<std::uint32_t> buffer(kWords, stream.get());
  EXPECT_THROW(buffer.grow(all, stream.get()), CudaError);
  EXPECT_EQ(buffer.size(), 0U);
  EXPECT_TRUE(buffer.grow(kWords, stream.get())) << "what there is can be had again";
}

}  // namespace
}  // namespace deformable_contact_monitor
