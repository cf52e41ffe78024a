// The device memory that a result tells, beside what nvidia-smi tells of the process.
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "cuda/cuda_detector.h"
#include "device_test.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// Returns what nvidia-smi tells of this process [MiB]; 0 if it does not, as in containers that
// number processes by themselves.
double mibOfNvidiaSmi() {
  constexpr const char* kCommand =
      "nvidia-smi --query-compute-apps=pid,used_memory --format=csv,noheader,nounits 2>/dev/null";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> lines(popen(kCommand, "r"), pclose);
  std::array<char, 256> line{};
  while (lines && std::fgets(line.data(), line.size(), lines.get()) != nullptr) {
    long id = 0;
    double mib = 0;
    if (std::sscanf(line.data(), "%ld, %lf", &id, &mib) == 2 && id == getpid()) return mib;
  }
  return 0;
}

class ProcessMemoryTest : public DeviceTest {};

TEST_F(ProcessMemoryTest, IsWhatNvidiaSmiTells) {
  if (!hasDevice()) return;
  constexpr double kMebibyte = 1 << 20;
  const auto detector = makeCudaDetector();
  Scene scene = selfScene(clothGrid(100, 1, 0, 0.1F));
  std::uint64_t last = 0;
  for (const bool geometry : {false, true}) {
    Options options;
    options.geometry = geometry;
    const DetectionResult& result = detector->detect(scene, options);
    EXPECT_GE(result.memory_bytes, result.detector_bytes);
    EXPECT_GE(result.memory_bytes, last) << "kernels stay";
    EXPECT_GT(result.detector_bytes, 0U);
    last = result.memory_bytes;
    const double told_mib = mibOfNvidiaSmi();
    EXPECT_EQ(told_mib > 0, result.memory_is_whole);
    if (told_mib == 0) continue;
    EXPECT_NEAR(result.memory_bytes / kMebibyte, told_mib, 0.1 * told_mib);
  }
}

// A cycle like an earlier one does not ask the driver, and tells the same.
TEST_F(ProcessMemoryTest, IsKeptWhileNothingChanges) {
  if (!hasDevice()) return;
  const auto detector = makeCudaDetector();
  const Scene scene = selfScene(clothGrid(20, 1, 0, 0.1F));
  detector->detect(scene, Options());
  const std::uint64_t bytes = detector->detect(scene, Options()).memory_bytes;
  EXPECT_EQ(detector->detect(scene, Options()).memory_bytes, bytes);
  EXPECT_GT(bytes, 0U);
}

}  // namespace
}  // namespace deformable_contact_monitor
