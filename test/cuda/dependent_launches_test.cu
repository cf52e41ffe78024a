// Tests where programmatic dependent launch is used, on the host alone.
#include <gtest/gtest.h>

#include "cuda/device/launch.cuh"

namespace deformable_contact_monitor {
namespace {

// A runtime newer than the driver works with it, but the driver records no early launches.
TEST(DependentLaunches, NeedDriverRuntimeAndDevice) {
  constexpr bool kRuntimeKnows = CUDART_VERSION >= 12030;
  EXPECT_EQ(DeviceTraits::supportsDependentLaunches(12030, 9), kRuntimeKnows);
  EXPECT_EQ(DeviceTraits::supportsDependentLaunches(13000, 12), kRuntimeKnows);
  for (const int driver : {0, 11040, 12000, 12010, 12020}) {
    EXPECT_FALSE(DeviceTraits::supportsDependentLaunches(driver, 9)) << driver;
  }
  for (const int capability : {7, 8}) {
    EXPECT_FALSE(DeviceTraits::supportsDependentLaunches(13000, capability)) << capability;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
