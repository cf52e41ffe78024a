// Tests that need a device.
#pragma once

#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include "test_data.h"

namespace deformable_contact_monitor {

class DeviceTest : public testing::Test {
 protected:
  // A failure where one is required.
  static bool hasDevice() {
    int count = 0;
    const bool has = cudaGetDeviceCount(&count) == cudaSuccess && count > 0;
    EXPECT_TRUE(has || !isCudaRequired());
    return has;
  }
};

}  // namespace deformable_contact_monitor
