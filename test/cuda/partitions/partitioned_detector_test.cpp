// Tests what several devices do when some of them fail, and where the partitions' bounds are. The
// devices are stand-ins.
#include "cuda/partitions/partitioned_detector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "cuda/device/cuda_error.h"
#include "cuda/partitions/partition_bounds.h"
#include "in_child.h"
#include "pair_sets.h"
#include "partition_stand_in.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// Says what happens to devices, by their numbers.
struct Plan {
  std::set<int> cannot_be_made, fails;
  std::set<int> has_no_room;  // the scene is too dense for it
  std::vector<int> ran;       // in detect(), from the caller's thread and others
  std::mutex mutex;
};

class PlannedDevice : public PartitionStandIn {
 public:
  PlannedDevice(int device, Plan& plan) : device_(device), plan_(plan) {
    if (plan.cannot_be_made.count(device) != 0) {
      throw CudaError(BackendFault::kUnavailable, "no device " + std::to_string(device));
    }
  }
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    const std::lock_guard<std::mutex> lock(plan_.mutex);
    plan_.ran.push_back(device_);
    if (plan_.has_no_room.count(device_) != 0) {
      throw CudaError(BackendFault::kSceneTooLarge, "too dense");
    }
    if (plan_.fails.count(device_) != 0) {
      throw CudaError(BackendFault::kSticky, "device " + std::to_string(device_) + " is lost");
    }
    return PartitionStandIn::detect(scene, options);
  }

 private:
  const int device_;
  Plan& plan_;
};

class PartitionedDetector : public ::testing::Test {
 protected:
  std::unique_ptr<Detector> make(std::vector<int> devices) {
    CudaSettings settings;
    settings.devices = std::move(devices);
    settings.shared_from_triangles = 100;
    settings.device_lost = [this](const BackendError& error) { told_.emplace_back(error.what()); };
    return makePartitionedDetector(settings, [this](const CudaSettings& its) {
      EXPECT_TRUE(its.devices.empty());
      return std::make_unique<PlannedDevice>(its.device, plan_);
    });
  }

  // Returns the devices that ran, ascending.
  std::vector<int> detect(Detector& detector) {
    plan_.ran.clear();
    EXPECT_TRUE(samePairs(expected_, detector.detect(scene_).contacts));
    std::sort(plan_.ran.begin(), plan_.ran.end());
    return plan_.ran;
  }

  using Devices = std::vector<int>;
  using Texts = std::vector<std::string>;
  Plan plan_;
  Texts told_;
  const Scene scene_ = pairScene(clothGrid(10, 1, 0, 0.2F), clothGrid(10, 1, 0.05F, 0));
  const std::vector<TrianglePair> expected_ = makeCpuDetector()->detect(scene_).contacts;
};

TEST_F(PartitionedDetector, AllTakePart) {
  ASSERT_FALSE(expected_.empty());
  const auto detector = make({0, 3, 5});
  EXPECT_EQ(detect(*detector), (Devices{0, 3, 5}));
  EXPECT_TRUE(told_.empty());
}

TEST_F(PartitionedDetector, AreRefusedInAForkedProcess) {
  auto one = make({0}), several = make({0, 1, 2});
  detect(*several);
  EXPECT_EQ(0, inChild([&] {
              const auto refuses = [](const auto& call) {
                try {
                  call();
                } catch (const BackendError& error) {
                  return error.fault() == BackendFault::kUnavailable;
                }
                return false;
              };
              const bool all = refuses([&] { one->detect(scene_); }) &&
                               refuses([&] { several->detect(scene_); }) && refuses([&] {
                                 make({0, 1});
                               });
              one = nullptr;
              several = nullptr;
              return all;
            }));
  EXPECT_EQ(detect(*several), (Devices{0, 1, 2}));
}

TEST_F(PartitionedDetector, SmallScenesStayOnTheFirst) {
  const auto detector = make({4, 1});
  const Scene small = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0));
  EXPECT_FALSE(detector->detect(small).contacts.empty());
  EXPECT_EQ(plan_.ran, (Devices{4}));
  EXPECT_EQ(detect(*detector), (Devices{1, 4}));
  EXPECT_TRUE(
      samePairs(makeCpuDetector()->detect(small).contacts, detector->detect(small).contacts))
      << "the first has all of it again";
}

TEST_F(PartitionedDetector, WhereTheSceneWasTooDenseADeviceIsStillThere) {
  const auto detector = make({0, 1, 2});
  plan_.has_no_room = {1};
  EXPECT_THROW(detector->detect(scene_, Options()), BackendError);
  plan_.has_no_room.clear();
  plan_.fails = {0};
  const Scene small = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0));
  plan_.ran.clear();
  EXPECT_FALSE(detector->detect(small).contacts.empty());
  EXPECT_EQ(plan_.ran, (Devices{0, 1})) << "the next one takes the place of the first";
  EXPECT_EQ(detect(*detector), (Devices{1, 2}));
  EXPECT_EQ(told_.size(), 1U);
}

TEST_F(PartitionedDetector, TheRestMakeTheCycleAgain) {
  const auto detector = make({0, 1, 2});
  detect(*detector);
  plan_.fails = {1};
  EXPECT_EQ(detect(*detector), (Devices{0, 0, 1, 2, 2}));
  EXPECT_EQ(told_, (Texts{"CUDA device 1: device 1 is lost"}));
  EXPECT_EQ(detect(*detector), (Devices{0, 2})) << "it is not asked again";
  plan_.fails = {0};
  EXPECT_EQ(detect(*detector), (Devices{0, 2, 2}));
  EXPECT_EQ(detect(*detector), (Devices{2}));
  EXPECT_EQ(told_, (Texts{"CUDA device 1: device 1 is lost", "CUDA device 0: device 0 is lost"}));
}

TEST_F(PartitionedDetector, ASmallSceneGoesToTheNext) {
  const auto detector = make({0, 1});
  plan_.fails = {0};
  const Scene small = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0));
  EXPECT_FALSE(detector->detect(small).contacts.empty());
  EXPECT_EQ(plan_.ran, (Devices{0, 1}));
}

TEST_F(PartitionedDetector, FailsWhenAllHave) {
  const auto detector = make({0, 1, 2});
  plan_.fails = {0, 1};
  EXPECT_EQ(detect(*detector), (Devices{0, 1, 2, 2}));
  plan_.fails = {0, 1, 2};
  try {
    detector->detect(scene_);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const BackendError& error) {
    EXPECT_EQ(error.fault(), BackendFault::kSticky);
    EXPECT_STREQ(error.what(), "device 2 is lost");
  }
}

TEST_F(PartitionedDetector, WhatCannotBeMadeIsDoneWithout) {
  plan_.cannot_be_made = {7};
  const auto detector = make({7, 0, 1});
  EXPECT_EQ(told_, (Texts{"CUDA device 7: no device 7"}));
  EXPECT_EQ(detect(*detector), (Devices{0, 1}));
  EXPECT_EQ(detect(*make({7, 2})), (Devices{2}));
  EXPECT_THROW(make({7, 7}), CudaError);
}

// Neither is a device's fault.
TEST_F(PartitionedDetector, ASceneThatIsTooLargeAndBadOptionsGoToTheCaller) {
  const auto detector = make({0, 1});
  plan_.has_no_room = {1};
  EXPECT_THROW(detector->detect(scene_), BackendError);
  plan_.has_no_room.clear();
  Options bad;
  bad.fuzzifier = 0;
  EXPECT_THROW(detector->detect(scene_, bad), std::invalid_argument);
  EXPECT_TRUE(told_.empty());
  EXPECT_EQ(detect(*detector), (Devices{0, 1}));
}

TEST(PartitionBounds, FillTheLine) {
  for (const std::size_t count : {1U, 2U, 5U, 9U}) {
    for (const Scene& scene :
         {Scene(), selfScene(clothGrid(1, 1, 0, 0)), selfScene(clothGrid(40, 1, 0, 0.1F))}) {
      const std::vector<ScenePartition> partitions = PartitionBounds().cut(scene, count);
      ASSERT_EQ(partitions.size(), count);
      EXPECT_EQ(partitions.front().low, -INFINITY);
      EXPECT_EQ(partitions.back().high, INFINITY);
      for (std::size_t s = 1; s < count; ++s) {
        EXPECT_EQ(partitions[s - 1].high, partitions[s].low);
        EXPECT_EQ(partitions[s - 1].axis, partitions[s].axis);
        EXPECT_LE(partitions[s - 1].low, partitions[s - 1].high);
      }
    }
  }
}

TEST(PartitionBounds, CutAcrossTheWidestAxisWhateverIsFarOff) {
  TriangleMesh mesh = clothGrid(40, 1, 0, 0.1F);
  for (std::size_t i = 1; i < mesh.vertices.size(); i += 3) mesh.vertices[i] *= 3;
  mesh.vertices[2] = 1e30F;
  mesh.vertices[5] = NAN;
  const ScenePartition first = PartitionBounds().cut(selfScene(mesh), 2).front();
  EXPECT_EQ(first.axis, 1);
  EXPECT_NEAR(first.high, 1.5, 0.1);
}

// A device takes as long as its partition is wide, from 0 on four times as long.
TEST(PartitionBounds, BecomeEvenByWhatThePartitionsTake) {
  const Scene scene = selfScene(clothGrid(200, 1, 0, 0.1F));
  PartitionBounds bounds;
  const auto costUpTo = [](double x) { return x < 0.5 ? 4 * x : 2 + (x - 0.5); };
  double worst = 0;
  for (int cycle = 0; cycle < 200; ++cycle) {
    const std::vector<ScenePartition>& partitions = bounds.cut(scene, 3);
    std::vector<double> took_ms;
    for (const ScenePartition& partition : partitions) {
      took_ms.push_back(costUpTo(std::min<double>(partition.high, 1)) -
                        costUpTo(std::max<double>(partition.low, 0)));
    }
    worst = *std::max_element(took_ms.begin(), took_ms.end());
    bounds.note(took_ms);
  }
  EXPECT_NEAR(worst, 2.5 / 3, 0.05);
}

// No cut divides a place, so its partition always takes longest.
TEST(PartitionBounds, FollowCostlyMaterialAfterAnyNumberOfCycles) {
  TriangleMesh line;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    line.vertices.insert(line.vertices.end(), {static_cast<float>(i), 0, 0});
    line.triangles.push_back(i);
  }
  const Scene scene = selfScene(std::move(line));
  PartitionBounds bounds;
  const auto cutAfter = [&](int cycles, float spot) {
    float cut = 0;
    for (int cycle = 0; cycle < cycles; ++cycle) {
      const std::vector<ScenePartition>& partitions = bounds.cut(scene, 2);
      std::vector<double> took_ms;
      for (const ScenePartition& one : partitions) {
        const double width = std::min(one.high, 3000.0F) - std::max(one.low, 0.0F);
        took_ms.push_back(0.2 + 1e-4 * width + (one.low <= spot && spot < one.high ? 2 : 0));
      }
      cut = partitions.front().high;
      bounds.note(took_ms);
    }
    return cut;
  };
  EXPECT_NEAR(cutAfter(400, 300), 300, 60);
  EXPECT_NEAR(cutAfter(20000, 300), 300, 60);
  EXPECT_NEAR(cutAfter(2000, 2700), 2700, 60);
}

}  // namespace
}  // namespace deformable_contact_monitor
