// The counters of lists on the device: however much is counted, a list that has no room for it
// never seems to have had room.
#include <gtest/gtest.h>

#include <cstdint>

#include "cuda/device/check.cuh"
#include "cuda/device/stream.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "device_test.h"

namespace deformable_contact_monitor {
namespace {

class ListCounters : public DeviceTest {};

// Each warp reserves places again and again: all lanes one each, or one lane many.
__global__ void reserveKernel(std::uint32_t* counter, std::uint32_t times, std::uint32_t many) {
  for (std::uint32_t i = 0; i < times; ++i) {
    if (many == 0) {
      warpReserve(counter, true);
    } else if (laneId() == 0) {
      reserve(counter, many);
    }
  }
}

// Returns what the counter is after so many reservations by each of 8192 warps.
std::uint32_t counted(std::uint32_t times, std::uint32_t many) {
  CudaStream stream;
  DeviceBuffer<std::uint32_t> counter;
  counter.grow(1, stream.get());
  std::uint32_t value = 0;
  counter.upload(&value, 1, stream.get());
  reserveKernel<<<256, 1024, 0, stream.get()>>>(counter.data(), times, many);
  checkCuda(cudaGetLastError(), "reserveKernel");
  counter.download(&value, 1, stream.get());
  stream.synchronise();
  return value;
}

TEST_F(ListCounters, CountExactlyAsFarAsListsReach) {
  if (!hasDevice()) return;
  EXPECT_EQ(8192U * 32U * 100U, counted(100, 0));
  EXPECT_EQ(8192U * 1000U, counted(1, 1000));
}

TEST_F(ListCounters, DoNotWrap) {
  if (!hasDevice()) return;
  // 5.2e9 and 4.4e9 places: with 32 bits the rest would be 0.9e9 and 0.1e9.
  EXPECT_GE(counted(20000, 0), kMostCounted);
  EXPECT_GE(counted(5400, 100), kMostCounted);
}

}  // namespace
}  // namespace deformable_contact_monitor
