// Tests what a failing device costs: some cycles on the CPU when memory runs out, CUDA for good
// when the context is dead.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "cuda/cuda_detector.h"
#include "cuda/detector_choice.h"
#include "cuda/device/check.cuh"
#include "pair_sets.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

TEST(DeviceFailures, AreToldApart) {
  for (const cudaError_t status : {cudaErrorMemoryAllocation, cudaErrorDevicesUnavailable}) {
    EXPECT_EQ(faultOf(status), BackendFault::kTransient) << cudaGetErrorName(status);
  }
  for (const cudaError_t status : {cudaErrorIllegalAddress, cudaErrorLaunchFailure,
                                   cudaErrorECCUncorrectable, cudaErrorAssert}) {
    EXPECT_EQ(faultOf(status), BackendFault::kSticky) << cudaGetErrorName(status);
  }
  for (const cudaError_t status :
       {cudaErrorNoDevice, cudaErrorInsufficientDriver, cudaErrorCallRequiresNewerDriver}) {
    EXPECT_EQ(faultOf(status), BackendFault::kUnavailable) << cudaGetErrorName(status);
  }
}

bool hasDevice() {
  try {
    makeCudaDetector();
    return true;
  } catch (const CudaError& error) {
    EXPECT_FALSE(isCudaRequired()) << error.what();
    return false;
  }
}

// All of the device's memory that can be had, until this goes.
class MemoryHog {
 public:
  MemoryHog() {
    constexpr std::size_t kLeast = std::size_t{1} << 16;
    for (std::size_t bytes = std::size_t{1} << 34; bytes >= kLeast; bytes /= 2) {
      void* block = nullptr;
      while (cudaMalloc(&block, bytes) == cudaSuccess) blocks_.push_back(block);
      cudaGetLastError();
    }
  }
  MemoryHog(const MemoryHog&) = delete;
  MemoryHog& operator=(const MemoryHog&) = delete;
  ~MemoryHog() {
    for (void* block : blocks_) cudaFree(block);
  }

 private:
  std::vector<void*> blocks_;
};

Scene smallScene() { return pairScene(clothGrid(20, 1, 0, 0.1F), clothGrid(20, 1, 0.01F, 0)); }
Scene wideScene() { return pairScene(clothGrid(400, 1, 0, 0.1F), clothGrid(400, 1, 0.01F, 0)); }

// Uses a clock that the test moves.
struct Monitored {
  std::chrono::steady_clock::time_point now{std::chrono::hours(3)};
  std::vector<BackendState> reported;
  std::unique_ptr<Detector> detector = makeDetectorPool(settings());

  PoolSettings settings() {
    PoolSettings pool;
    pool.device = [] { return makeCudaDetector(); };
    pool.cpu = [] { return makeCpuDetector(); };
    pool.changed = [this](const BackendState& state) { reported.push_back(state); };
    pool.retry = RetryTimes{5, 60, [this] { return now; }};
    return pool;
  }

  // A cycle finds what the CPU finds. Returns the backend that ran.
  std::string detect(const Scene& scene) {
    const auto expected = makeCpuDetector()->detect(scene, Options()).contacts;
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(samePairs(expected, detector->detect(scene, Options()).contacts));
    return detector->backend();
  }
};

TEST(DeviceFailures, OutOfMemoryIsTransient) {
  if (!hasDevice()) return;
  const auto detector = makeCudaDetector();
  const MemoryHog hog;
  try {
    detector->detect(wideScene(), Options());
    ADD_FAILURE() << "there was memory left";
  } catch (const CudaError& error) {
    EXPECT_EQ(error.fault(), BackendFault::kTransient) << error.what();
    EXPECT_NE(std::string(error.what()).find("memory"), std::string::npos) << error.what();
  }
}

// A detector that has grown for a scene asks for as much ever after. So the pool makes a new one.
TEST(DeviceFailures, CudaAloneTakesASmallSceneAfterOneThatIsTooLarge) {
  if (!hasDevice()) return;
  PoolSettings settings;
  settings.device = [] { return makeCudaDetector(); };
  const auto detector = makeDetectorPool(settings);
  void* left = nullptr;
  ASSERT_EQ(cudaMalloc(&left, std::size_t{100} << 20), cudaSuccess);
  const MemoryHog hog;
  ASSERT_EQ(cudaFree(left), cudaSuccess);
  EXPECT_THROW(detector->detect(wideScene(), Options()), CudaError);
  const auto expected = makeCpuDetector()->detect(smallScene(), Options()).contacts;
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(samePairs(expected, detector->detect(smallScene(), Options()).contacts));
  }
}

TEST(DeviceFailures, AfterOutOfMemoryCudaComesBack) {
  if (!hasDevice()) return;
  Monitored monitored;
  EXPECT_EQ(monitored.detect(smallScene()), "cuda");
  {
    const MemoryHog hog;
    EXPECT_EQ(monitored.detect(wideScene()), "cpu");
    ASSERT_EQ(monitored.reported.size(), 1U);
    EXPECT_EQ(monitored.reported[0].fault, BackendFault::kTransient);
    EXPECT_TRUE(monitored.reported[0].tried_again);
    monitored.now += std::chrono::seconds(5);
    EXPECT_EQ(monitored.detect(wideScene()), "cpu") << "still none";
  }
  EXPECT_EQ(monitored.detect(wideScene()), "cpu") << "it is not time yet";
  monitored.now += std::chrono::seconds(10);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(monitored.detect(wideScene()), "cuda");
  EXPECT_TRUE(monitored.reported.back().problem.empty());
}

// Keeps every multiprocessor to itself for so long.
__global__ void hold(unsigned long long nanoseconds) {
  unsigned long long begin = 0, now = 0;
  asm volatile("mov.u64 %0, %globaltimer;" : "=l"(begin));
  do {
    asm volatile("mov.u64 %0, %globaltimer;" : "=l"(now));
  } while (now - begin < nanoseconds);
}

// A device that others keep busy, for a second in all, until this goes.
class BusyDevice {
 public:
  BusyDevice() {
    cudaDeviceProp device{};
    EXPECT_EQ(cudaGetDeviceProperties(&device, 0), cudaSuccess);
    EXPECT_EQ(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), cudaSuccess);
    const int blocks = device.multiProcessorCount * device.maxThreadsPerMultiProcessor / 1024;
    for (int i = 0; i < 10; ++i) hold<<<blocks, 1024, 0, stream_>>>(100'000'000);
    EXPECT_EQ(cudaGetLastError(), cudaSuccess);
  }
  BusyDevice(const BusyDevice&) = delete;
  BusyDevice& operator=(const BusyDevice&) = delete;
  ~BusyDevice() {
    EXPECT_EQ(cudaStreamSynchronize(stream_), cudaSuccess);
    cudaStreamDestroy(stream_);
  }

  bool isBusy() const { return cudaStreamQuery(stream_) == cudaErrorNotReady; }

 private:
  cudaStream_t stream_ = nullptr;
};

TEST(DeviceFailures, ABusyDeviceCostsTimeAndNothingElse) {
  if (!hasDevice()) return;
  Monitored monitored;
  EXPECT_EQ(monitored.detect(smallScene()), "cuda");
  const auto expected = makeCpuDetector()->detect(smallScene(), Options()).contacts;
  int in_time = 0, late = 0;
  {
    const BusyDevice others;
    while (others.isBusy()) {
      Options options;
      options.limits.deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(20);
      const DetectionResult& result = monitored.detector->detect(smallScene(), options);
      EXPECT_TRUE(std::includes(expected.begin(), expected.end(), result.contacts.begin(),
                                result.contacts.end()));
      if (!result.cut_off) EXPECT_TRUE(samePairs(expected, result.contacts));
      ++(result.cut_off ? late : in_time);
    }
  }
  std::printf("while others had the device: %d cycles in time, %d cut off\n", in_time, late);
  EXPECT_GT(in_time + late, 0);
  EXPECT_EQ(monitored.detect(smallScene()), "cuda") << "nothing was wrong with it";
  EXPECT_TRUE(monitored.reported.empty());
}

__global__ void writeToNowhere(int* nowhere) { *nowhere = 1; }
__global__ void trap() { asm("trap;"); }

// Ends the process: 0 if all is as it should be.
void killContextAndGoOn(bool by_address) {
  Monitored monitored;
  int problems = monitored.detect(smallScene()) == "cuda" ? 0 : 1;
  if (by_address) {
    writeToNowhere<<<1, 1>>>(nullptr);
  } else {
    trap<<<1, 1>>>();
  }
  cudaDeviceSynchronize();
  for (int i = 0; i < 3; ++i) {
    if (monitored.detect(smallScene()) != "cpu") problems += 2;
    monitored.now += std::chrono::hours(1);
  }
  if (monitored.reported.size() != 1 || monitored.reported[0].fault != BackendFault::kSticky ||
      monitored.reported[0].tried_again) {
    problems += 16;
  }
  for (const BackendState& state : monitored.reported) {
    std::fprintf(stderr, "reported: %s\n", state.problem.c_str());
  }
  if (testing::Test::HasFailure()) problems += 32;
  monitored.detector.reset();  // may neither throw nor hang
  std::exit(problems);
}

bool hasTwoDevices() {
  int count = 0;
  return hasDevice() && cudaGetDeviceCount(&count) == cudaSuccess && count > 1;
}

// Two devices that divide each cycle, and the states that they report.
struct Pair {
  std::vector<BackendState> reported;
  std::unique_ptr<Detector> detector;

  Pair() {
    CudaSettings settings;
    settings.devices = {0, 1};
    settings.shared_from_triangles = 0;
    detector = makeDetector(BackendChoice::kCuda, WithoutCuda::kTryAgain, settings,
                            [this](const BackendState& state) { reported.push_back(state); });
  }
  bool finds(const Scene& scene) {
    const auto expected = makeCpuDetector()->detect(scene, Options()).contacts;
    const bool found = samePairs(expected, detector->detect(scene, Options()).contacts);
    return found && detector->backend() == "cuda";
  }
  bool lostOne(BackendFault fault) const {
    return reported.size() == 1 && reported[0].partly && reported[0].fault == fault &&
           reported[0].problem.find("CUDA device 1: ") == 0;
  }
};

TEST(DeviceFailures, OfTwoDevicesOneGoesOnWhereTheOtherIsOutOfMemory) {
  if (!hasTwoDevices()) return;
  Pair pair;
  EXPECT_TRUE(pair.finds(smallScene()));
  cudaSetDevice(1);
  const MemoryHog hog;
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(pair.finds(wideScene()));
  EXPECT_TRUE(pair.lostOne(BackendFault::kTransient));
  cudaSetDevice(0);
}

// A dead context may cost the whole process CUDA: then the CPU goes on.
void killOneOfTwoAndGoOn() {
  Pair pair;
  int problems = pair.finds(smallScene()) ? 0 : 1;
  cudaSetDevice(1);
  writeToNowhere<<<1, 1>>>(nullptr);
  cudaDeviceSynchronize();
  const auto expected = makeCpuDetector()->detect(wideScene(), Options()).contacts;
  for (int i = 0; i < 3; ++i) {
    if (!samePairs(expected, pair.detector->detect(wideScene(), Options()).contacts)) problems += 2;
  }
  const bool reported_once = pair.reported.size() == 1 &&
                             pair.reported[0].fault == BackendFault::kSticky &&
                             pair.detector->backend() == (pair.reported[0].partly ? "cuda" : "cpu");
  if (!reported_once) problems += 16;
  for (const BackendState& state : pair.reported) {
    std::fprintf(stderr, "reported: %s\n", state.problem.c_str());
  }
  if (testing::Test::HasFailure()) problems += 32;
  pair.detector.reset();
  std::exit(problems);
}

TEST(DeviceFailures, OfTwoDevicesADeadOneCostsNoContact) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  if (!hasTwoDevices()) return;
  EXPECT_EXIT(killOneOfTwoAndGoOn(), testing::ExitedWithCode(0), "reported: ");
}

// In processes of their own, started afresh: a forked one cannot use CUDA.
TEST(DeviceFailures, ADeadContextIsSticky) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  if (!hasDevice()) return;
  for (const bool by_address : {true, false}) {
    EXPECT_EXIT(killContextAndGoOn(by_address), testing::ExitedWithCode(0), "reported: ")
        << by_address;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
