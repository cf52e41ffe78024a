// Tests which backend runs when the first one fails at the start or later.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "pair_sets.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// Controls how the first backend behaves, and counts its instances and calls.
struct Device {
  std::exception_ptr make_fails, detect_fails;
  std::size_t most_triangles = ~std::size_t{0};
  int made = 0, alive = 0, resets = 0, detections = 0;

  void fails(BackendFault fault) {
    detect_fails = std::make_exception_ptr(BackendError(fault, "it broke"));
  }
};

class DeviceDetector : public Detector {
 public:
  explicit DeviceDetector(Device* device) : device_(*device), works_(makeCpuDetector()) {
    ++device_.made;
    ++device_.alive;
  }
  ~DeviceDetector() override { --device_.alive; }
  std::string backend() const override { return "device"; }
  void reset() override { ++device_.resets; }
  void swapResult(DetectionResult& result) override { works_->swapResult(result); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    ++device_.detections;
    if (device_.detect_fails) std::rethrow_exception(device_.detect_fails);
    if (scene.triangleCount() > device_.most_triangles) {
      throw BackendError(BackendFault::kSceneTooLarge, "too large");
    }
    return works_->detect(scene, options);
  }

 private:
  Device& device_;
  std::unique_ptr<Detector> works_;
};

class Fallback : public testing::Test {
 protected:
  // Makes the pool. Its clock stands still until the test moves it.
  void make(bool tries_again = true) {
    PoolSettings settings;
    settings.device = [this]() -> std::unique_ptr<Detector> {
      if (device_.make_fails) std::rethrow_exception(device_.make_fails);
      return std::make_unique<DeviceDetector>(&device_);
    };
    settings.cpu = [] { return makeCpuDetector(); };
    settings.changed = [this](const BackendState& state) { told_.push_back(state); };
    if (tries_again) settings.retry = RetryTimes{5, 60, [this] { return now_; }};
    detector_ = makeDetectorPool(settings);
  }

  // A cycle loses nothing, whatever runs it. Returns the backend that did.
  std::string detect() { return detect(scene_); }
  std::string detect(const Scene& scene) {
    const auto expected = makeCpuDetector()->detect(scene, Options()).contacts;
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(samePairs(expected, detector_->detect(scene, Options()).contacts));
    return detector_->backend();
  }
  std::string detectAfter(double s) {
    now_ += std::chrono::milliseconds(static_cast<int>(1e3 * s));
    return detect();
  }

  Device device_;
  std::unique_ptr<Detector> detector_;
  std::vector<BackendState> told_;
  std::chrono::steady_clock::time_point now_{std::chrono::hours(3)};
  const Scene scene_ = pairScene(clothGrid(4, 1, 0, 0.1F), clothGrid(3, 1, 0.01F, 0));
  const Scene large_ = pairScene(clothGrid(8, 1, 0, 0.1F), clothGrid(8, 1, 0.01F, 0));
};

TEST_F(Fallback, RunsTheFirstWhileItWorks) {
  make();
  EXPECT_EQ(detector_->backend(), "device");
  EXPECT_EQ(detect(), "device");
  EXPECT_EQ(detectAfter(100), "device");
  EXPECT_EQ(device_.made, 1);
  EXPECT_TRUE(told_.empty());
}

// A detector that ran out of memory keeps asking for as much.
TEST_F(Fallback, WithoutASecondAFailureIsNotForGood) {
  PoolSettings settings;
  settings.device = [this]() -> std::unique_ptr<Detector> {
    if (device_.make_fails) std::rethrow_exception(device_.make_fails);
    return std::make_unique<DeviceDetector>(&device_);
  };
  detector_ = makeDetectorPool(settings);
  for (const BackendFault fault : {BackendFault::kTransient, BackendFault::kSceneTooLarge}) {
    const int made = device_.made;
    device_.fails(fault);
    EXPECT_THROW(detector_->detect(scene_, Options()), BackendError);
    EXPECT_EQ(detector_->backend(), "device");
    if (fault == BackendFault::kTransient) {  // memory is still short
      device_.make_fails = device_.detect_fails;
      EXPECT_THROW(detector_->detect(scene_, Options()), BackendError);
      device_.make_fails = nullptr;
    }
    device_.detect_fails = nullptr;
    EXPECT_EQ(detect(), "device");
    EXPECT_EQ(device_.made, made + (fault == BackendFault::kTransient ? 1 : 0));
    EXPECT_EQ(device_.alive, 1);
  }
}

TEST_F(Fallback, APoolWithoutMakersIsRefused) {
  EXPECT_THROW(makeDetectorPool({}), std::invalid_argument);
}

TEST_F(Fallback, RunsTheSecondForGoodWhereThereIsNoFirst) {
  device_.make_fails =
      std::make_exception_ptr(BackendError(BackendFault::kUnavailable, "no device"));
  make();
  EXPECT_EQ(detector_->backend(), "cpu");
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_EQ(told_[0].problem, "no device");
  EXPECT_EQ(told_[0].fault, BackendFault::kUnavailable);
  EXPECT_FALSE(told_[0].tried_again);
  device_.make_fails = nullptr;
  EXPECT_EQ(detect(), "cpu");
  EXPECT_EQ(detectAfter(1000), "cpu");
  EXPECT_EQ(told_.size(), 1U);
}

TEST_F(Fallback, ABusyDeviceIsTriedAgain) {
  device_.make_fails = std::make_exception_ptr(BackendError(BackendFault::kTransient, "busy"));
  make();
  EXPECT_EQ(detect(), "cpu");
  EXPECT_TRUE(told_.at(0).tried_again);
  device_.make_fails = nullptr;
  EXPECT_EQ(detectAfter(4.9), "cpu");
  EXPECT_EQ(detectAfter(0.1), "device");
  ASSERT_EQ(told_.size(), 2U);
  EXPECT_TRUE(told_[1].problem.empty());
}

TEST_F(Fallback, ATransientFailureCostsNoCycleAndIsOverOnceAnotherOneWorks) {
  make();
  EXPECT_EQ(detect(), "device");
  device_.fails(BackendFault::kTransient);
  EXPECT_EQ(detect(), "cpu");
  EXPECT_EQ(device_.alive, 0) << "its state is in doubt, and its memory is wanted";
  EXPECT_EQ(told_.at(0).problem, "it broke");
  EXPECT_EQ(told_[0].fault, BackendFault::kTransient);
  EXPECT_TRUE(told_[0].tried_again);
  device_.detect_fails = nullptr;
  EXPECT_EQ(detectAfter(4.9), "cpu");
  EXPECT_EQ(device_.made, 1);
  EXPECT_EQ(detectAfter(0.1), "device");
  EXPECT_EQ(device_.made, 2);
  ASSERT_EQ(told_.size(), 2U);
  EXPECT_TRUE(told_[1].problem.empty());
}

TEST_F(Fallback, WaitsTwiceAsLongEachTimeUpToAMinute) {
  make();
  device_.fails(BackendFault::kTransient);
  detect();
  for (const double wait_s : {5.0, 10.0, 20.0, 40.0, 60.0, 60.0}) {
    const int before = device_.detections;
    EXPECT_EQ(detectAfter(wait_s - 0.1), "cpu");
    EXPECT_EQ(device_.detections, before) << wait_s;
    EXPECT_EQ(detectAfter(0.1), "cpu");
    EXPECT_EQ(device_.detections, before + 1) << wait_s;
  }
  EXPECT_EQ(told_.size(), 1U) << "once";
}

TEST_F(Fallback, WhatFailsSoonAgainWaitsLonger) {
  make();
  device_.fails(BackendFault::kTransient);
  detect();
  device_.detect_fails = nullptr;
  EXPECT_EQ(detectAfter(5), "device");
  device_.fails(BackendFault::kTransient);
  EXPECT_EQ(detectAfter(4.9), "cpu");
  device_.detect_fails = nullptr;
  EXPECT_EQ(detectAfter(9.9), "cpu");
  EXPECT_EQ(detectAfter(0.1), "device");
  device_.fails(BackendFault::kTransient);
  EXPECT_EQ(detectAfter(10), "cpu") << "it worked as long as it had been left alone";
  device_.detect_fails = nullptr;
  EXPECT_EQ(detectAfter(5), "device");
}

TEST_F(Fallback, AStickyFailureIsForGood) {
  make();
  device_.fails(BackendFault::kSticky);
  EXPECT_EQ(detect(), "cpu");
  device_.detect_fails = nullptr;
  EXPECT_EQ(detectAfter(3600), "cpu");
  EXPECT_EQ(device_.detections, 1);
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_EQ(told_[0].fault, BackendFault::kSticky);
  EXPECT_FALSE(told_[0].tried_again);
}

TEST_F(Fallback, ATransientFailureMayTurnOutToBeSticky) {
  make();
  device_.fails(BackendFault::kTransient);
  detect();
  device_.make_fails = std::make_exception_ptr(BackendError(BackendFault::kSticky, "dead"));
  EXPECT_EQ(detectAfter(5), "cpu");
  EXPECT_EQ(told_.back().fault, BackendFault::kSticky);
  EXPECT_EQ(told_.back().problem, "dead");
  device_.make_fails = device_.detect_fails = nullptr;
  EXPECT_EQ(detectAfter(3600), "cpu");
}

TEST_F(Fallback, ASceneThatIsTooLargeCostsOthersNothing) {
  device_.most_triangles = scene_.triangleCount();
  make();
  EXPECT_EQ(detect(large_), "cpu");
  EXPECT_EQ(told_.at(0).fault, BackendFault::kSceneTooLarge);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(detect(scene_), "device");
    const int before = device_.detections;
    EXPECT_EQ(detect(large_), "cpu");
    EXPECT_EQ(device_.detections, before) << "it is known to be too large";
  }
  EXPECT_EQ(device_.made, 1) << "nothing is wrong with it";
  EXPECT_EQ(told_.size(), 1U) << "the large one still waits";
  EXPECT_EQ(detectAfter(5), "device");
  ASSERT_EQ(told_.size(), 2U);
  EXPECT_TRUE(told_[1].problem.empty());
}

// A scene can be too crowded for its size, and then no longer be.
TEST_F(Fallback, ASceneThatWasTooLargeIsTriedAgain) {
  make();
  device_.fails(BackendFault::kSceneTooLarge);
  EXPECT_EQ(detect(), "cpu");
  device_.detect_fails = nullptr;
  EXPECT_EQ(detectAfter(4.9), "cpu");
  EXPECT_EQ(detectAfter(0.1), "device");
  EXPECT_EQ(device_.made, 1);
  EXPECT_TRUE(told_.back().problem.empty());
}

TEST_F(Fallback, BodiesThatTakeNoPartMakeNoSceneLarge) {
  make();
  device_.fails(BackendFault::kSceneTooLarge);
  EXPECT_EQ(detect(large_), "cpu");
  device_.detect_fails = nullptr;
  Scene scene = pairScene(clothGrid(4, 1, 0, 0.1F), clothGrid(3, 1, 0.01F, 0));
  scene.addBody("bystander", clothGrid(20, 1, 0, 0));
  EXPECT_EQ(detect(scene), "device");
}

TEST_F(Fallback, AnyOtherRuntimeErrorIsTransient) {
  make();
  device_.detect_fails = std::make_exception_ptr(std::runtime_error("who knows"));
  EXPECT_EQ(detect(), "cpu");
  device_.detect_fails = nullptr;
  EXPECT_EQ(detectAfter(5), "device");
}

TEST_F(Fallback, WithoutRetryTimesEveryChangeIsForGood) {
  for (const BackendFault fault :
       {BackendFault::kTransient, BackendFault::kSceneTooLarge, BackendFault::kSticky}) {
    told_.clear();
    make(false);
    EXPECT_EQ(detect(large_), "device");
    device_.fails(fault);
    EXPECT_EQ(detect(large_), "cpu");
    device_.detect_fails = nullptr;
    EXPECT_EQ(detectAfter(3600), "cpu");
    EXPECT_EQ(told_.size(), 1U);
    EXPECT_FALSE(told_.at(0).tried_again);
  }
}

TEST_F(Fallback, ACycleThatIsCutOffIsNoReasonToFallBack) {
  make();
  Options options;
  options.limits.deadline = std::chrono::steady_clock::now();
  const DetectionResult& result = detector_->detect(scene_, options);
  EXPECT_TRUE(result.cut_off);
  EXPECT_EQ("no time", result.cut_off_because);
  EXPECT_EQ(detector_->backend(), "device");
  EXPECT_TRUE(told_.empty());
  EXPECT_FALSE(detector_->detect(scene_, Options()).contacts.empty());
}

TEST_F(Fallback, BadOptionsAreNoReasonToFallBack) {
  make();
  Options options;
  options.overlap = 2;
  EXPECT_THROW(detector_->detect(scene_, options), std::invalid_argument);
  EXPECT_EQ(detector_->backend(), "device");
  EXPECT_TRUE(told_.empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
