// Tests which detector each backend name selects. The requested CUDA device never exists.
#include "tools/common/backend_choice.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "cuda/device/cuda_error.h"

namespace deformable_contact_monitor {
namespace {

using Warnings = std::vector<std::string>;

std::unique_ptr<Detector> make(const std::string& backend, WithoutCuda without_cuda,
                               Warnings* warnings) {
  CudaSettings settings;
  settings.device = 1000000;
  return makeDetector(backend, without_cuda, settings,
                      [warnings](const std::string& why) { warnings->push_back(why); });
}

TEST(BackendChoice, NamesAreTheDetectors) {
  Warnings warnings;
  for (const std::string backend : {"cpu", "brute_force"}) {
    EXPECT_EQ(make(backend, WithoutCuda::kRefuse, &warnings)->backend(), backend);
  }
  EXPECT_EQ(make("auto", WithoutCuda::kRefuse, &warnings)->backend(), "cpu");
  EXPECT_TRUE(warnings.empty());  // nobody asked for CUDA
  EXPECT_THROW(make("none", WithoutCuda::kFallBack, &warnings), std::invalid_argument);
}

TEST(BackendChoice, WhoAskedForCudaIsTold) {
  Warnings warnings;
  EXPECT_EQ(make("cuda", WithoutCuda::kFallBack, &warnings)->backend(), "cpu");
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].rfind("CUDA cannot be used, so on the CPU: ", 0), 0U) << warnings[0];
  EXPECT_THROW(make("cuda", WithoutCuda::kRefuse, &warnings), CudaError);
  EXPECT_EQ(warnings.size(), 1U);
}

TEST(BackendChoice, FclIsThereOrSaysHowToGetIt) {
  Warnings warnings;
#ifdef DCM_HAVE_FCL
  const auto fcl = make("fcl", WithoutCuda::kFallBack, &warnings);
  EXPECT_EQ(fcl->backend(), "fcl");
  EXPECT_FALSE(supportsMargins(*fcl));
#else
  EXPECT_THROW(make("fcl", WithoutCuda::kFallBack, &warnings), std::runtime_error);
#endif
}

}  // namespace
}  // namespace deformable_contact_monitor
