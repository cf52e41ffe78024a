// Scenes whose enabled pairs take turns: each set of pairs finds its detector as it left it.
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// A plate that cloths of different sizes lie on; the objects of a monitor take turns like them.
class Turns {
 public:
  Turns() {
    for (const int n : {40, 30, 20, 15}) {
      cloths_.push_back(scene_.addBody("cloth", clothGrid(n, 1, 0.01F, 0.03F)));
    }
  }

  // Only this cloth's pair is enabled, and it has moved.
  const Scene& turnOf(std::size_t cloth) {
    for (const BodyId id : cloths_) scene_.setPairEnabled(plate_, id, id == cloths_[cloth]);
    RigidTransform pose;
    pose.translation[0] = 1e-3 * ++turns_;
    scene_.setPose(cloths_[cloth], pose);
    return scene_;
  }

  void changeTopologyOf(std::size_t cloth) {
    scene_.setMesh(cloths_[cloth], clothGrid(25, 1, 0.01F, 0.03F));
  }

  std::size_t count() const { return cloths_.size(); }

 private:
  Scene scene_;
  BodyId plate_ = scene_.addBody("plate", clothGrid(30, 1, 0, 0.01F));
  std::vector<BodyId> cloths_;
  int turns_ = 0;
};

PoolSettings poolOf(DetectorMaker make) {
  PoolSettings settings;
  settings.cpu = std::move(make);
  return settings;
}

// Returns a pool as programs get it: the CPU's detectors share their arrays.
std::unique_ptr<Detector> poolOf(const Backend& backend) {
  const bool is_cpu = std::string(backend.name) == "cpu";
  return makeDetectorPool(poolOf(is_cpu ? cpuDetectorMaker() : DetectorMaker(backend.make)));
}

class WarmDetectorsSuite : public testing::TestWithParam<Backend> {
 protected:
  bool startsCold(Detector& detector, const Scene& scene) {
    const DetectionResult& result = detector.detect(scene, Options());
    const auto expected = makeBruteForceDetector()->detect(scene, Options()).contacts;
    EXPECT_FALSE(expected.empty());
    EXPECT_TRUE(samePairs(expected, result.contacts));
    return result.started_cold;
  }

  Turns turns_;
};

TEST_P(WarmDetectorsSuite, OnlyTheFirstTurnOfEachSetStartsCold) {
  const auto detector = poolOf(GetParam());
  for (int round = 0; round < 4; ++round) {
    for (std::size_t i = 0; i < turns_.count(); ++i) {
      EXPECT_EQ(startsCold(*detector, turns_.turnOf(i)), round == 0) << i << " in " << round;
    }
  }
}

TEST_P(WarmDetectorsSuite, AnotherTopologyConcernsItsOwnPairsAlone) {
  const auto detector = poolOf(GetParam());
  for (std::size_t i = 0; i < turns_.count(); ++i) startsCold(*detector, turns_.turnOf(i));
  turns_.changeTopologyOf(0);
  EXPECT_FALSE(startsCold(*detector, turns_.turnOf(1)));
  EXPECT_FALSE(startsCold(*detector, turns_.turnOf(2)));
  startsCold(*detector, turns_.turnOf(0));
}

// A backend by itself.
TEST_P(WarmDetectorsSuite, PairsThatWereOffForAWhileStartWarm) {
  const auto detector = GetParam().make();
  EXPECT_TRUE(startsCold(*detector, turns_.turnOf(0)));
  turns_.turnOf(1);
  EXPECT_FALSE(startsCold(*detector, turns_.turnOf(0)));
}

TEST_P(WarmDetectorsSuite, ResetConcernsAllSets) {
  const auto detector = poolOf(GetParam());
  for (int reset = 0; reset < 2; ++reset) {
    for (std::size_t i = 0; i < turns_.count(); ++i) {
      EXPECT_TRUE(startsCold(*detector, turns_.turnOf(i)));
    }
    detector->reset();
  }
}

// The caller keeps each result while the detector goes on with the memory of an older one.
TEST_P(WarmDetectorsSuite, AResultThatWasHandedOverOutlivesLaterCycles) {
  const auto detector = poolOf(GetParam());
  DetectionResult kept;
  std::vector<TrianglePair> expected;
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = 0; i < turns_.count(); ++i) {
      const Scene& scene = turns_.turnOf(i);
      detector->detect(scene, Options());
      EXPECT_EQ(std::vector<TrianglePair>(kept.contacts), expected) << i << " in " << round;
      detector->swapResult(kept);
      expected = makeBruteForceDetector()->detect(scene, Options()).contacts;
      EXPECT_TRUE(samePairs(expected, kept.contacts)) << i << " in " << round;
      expected = kept.contacts;
    }
  }
}

// Between two turns of a set, another one runs at several moments and as a motion.
TEST_P(WarmDetectorsSuite, SweptTurnsBetweenChangeNothing) {
  const auto detector = poolOf(GetParam());
  Options swept;
  swept.motion = Motion::kSwept;
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < turns_.count(); ++i) {
      startsCold(*detector, turns_.turnOf(i));
      const Scene& other = turns_.turnOf((i + 1) % turns_.count());
      const auto expected = makeBruteForceDetector()->detect(other, swept).contacts;
      EXPECT_TRUE(samePairs(expected, detector->detect(other, swept).contacts));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, WarmDetectorsSuite, ::testing::ValuesIn(productBackends()), backendName);

// Returns the memory of this process that is in use [bytes].
std::size_t residentBytes() {
  std::size_t total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// Links come and go, as when their transforms are missing now and then: each cycle has another set
// of pairs, up to the most detectors that a pool makes.
TEST(WarmDetectorsOnTheCpu, ManySetsOfPairsTakeLittleMemory) {
  Scene scene;
  const BodyId cloth = scene.addBody("cloth", clothGrid(150, 1, 0.01F, 0.03F));
  scene.setPairEnabled(cloth, cloth, true);
  std::vector<BodyId> links;
  for (int i = 0; i < 7; ++i) links.push_back(scene.addBody("link", clothGrid(5, 1, 0, 0.01F)));
  const auto detector = makeDetectorPool(poolOf(cpuDetectorMaker()));
  Options options;
  options.nearest = true;
  options.threads = 2;  // the allocator keeps memory for each thread
  std::size_t after_few = 0;
  for (unsigned set = 0; set < 100; ++set) {
    for (std::size_t i = 0; i < links.size(); ++i) {
      scene.setPairEnabled(links[i], cloth, (set >> i & 1U) != 0);
    }
    detector->detect(scene, options);
    if (set == 4) after_few = residentBytes();
  }
  ASSERT_GT(after_few, 0U);
  [[maybe_unused]] const std::size_t grown = residentBytes() - std::min(residentBytes(), after_few);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these keep what was freed
  EXPECT_LT(grown, scene.triangleCount() * 1000) << "bytes";  // unshared: 20 000 bytes a triangle
#endif
}

// Says how it is used.
class CountingDetector : public Detector {
 public:
  explicit CountingDetector(std::vector<int>* cycles) : cycles_(*cycles), number_(cycles->size()) {
    cycles_.push_back(0);
  }
  std::string backend() const override { return "counting"; }
  void reset() override {}
  void swapResult(DetectionResult& result) override { result_.swap(result); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    ++cycles_[number_];
    if (scene.body(0).name == "bad") throw std::runtime_error("it broke");
    result_.begin(scene, options, true);
    result_.detector_bytes = cycles_[number_] == 1 ? 100 : 0;  // cut off at once
    return result_;
  }

 private:
  std::vector<int>& cycles_;  // of each that was made
  const std::size_t number_;
  DetectionResult result_;
};

class PoolLimitsTest : public testing::Test {
 protected:
  void make(std::size_t most_detectors = 128, std::uint64_t memory_bytes = 1000) {
    PoolSettings settings = poolOf([this] { return std::make_unique<CountingDetector>(&cycles_); });
    settings.most_detectors = most_detectors;
    settings.memory_bytes = memory_bytes;
    detector_ = makeDetectorPool(settings);
  }
  void turns(const std::vector<std::size_t>& cloths) {
    for (const std::size_t i : cloths) detector_->detect(turns_.turnOf(i), Options());
  }

  Turns turns_;
  std::vector<int> cycles_;
  std::unique_ptr<Detector> detector_;
};

TEST_F(PoolLimitsTest, TheFirstIsMadeAtOnceAndUsed) {
  make();
  EXPECT_EQ(cycles_, std::vector<int>({0}));
  EXPECT_EQ(detector_->backend(), "counting");
  turns({0, 0, 1, 0});
  EXPECT_EQ(cycles_, std::vector<int>({3, 1}));
}

TEST_F(PoolLimitsTest, BeyondTheirNumberTheLongestIdleIsTakenOver) {
  make(2);
  turns({0, 1, 0});
  EXPECT_EQ(cycles_, std::vector<int>({2, 1}));
  turns({2});  // takes over that of 1
  EXPECT_EQ(cycles_, std::vector<int>({2, 2}));
  turns({0, 2});
  EXPECT_EQ(cycles_, std::vector<int>({3, 3}));
  turns({1});  // and now that of 0
  EXPECT_EQ(cycles_, std::vector<int>({4, 3}));
}

TEST_F(PoolLimitsTest, OfSeveralTheLongestIdleIsTakenOver) {
  make(3);
  turns({0, 1, 2, 0, 3});  // that of 1
  EXPECT_EQ(cycles_, std::vector<int>({2, 2, 1}));
  turns({2, 0});
  EXPECT_EQ(cycles_, std::vector<int>({3, 2, 2}));
}

TEST_F(PoolLimitsTest, BeyondTheirMemoryToo) {
  make(10, 150);
  turns({0, 0, 1, 1, 2});
  EXPECT_EQ(cycles_, std::vector<int>({3, 2}));
}

TEST_F(PoolLimitsTest, WhatADetectorThrowsGoesToTheCaller) {
  make();
  Scene bad;
  bad.addBody("bad", clothGrid(1, 1, 0, 0));
  bad.setPairEnabled(0, 0, true);
  EXPECT_THROW(detector_->detect(bad, Options()), std::runtime_error);
  turns({0});
  EXPECT_EQ(cycles_, std::vector<int>({1, 1}));
}

TEST(PairSets, ADetectorThatCannotBeMadeSaysSoAtOnce) {
  const auto fails = []() -> std::unique_ptr<Detector> { throw std::runtime_error("no device"); };
  EXPECT_THROW(makeDetectorPool(poolOf(fails)), std::runtime_error);
}

}  // namespace
}  // namespace deformable_contact_monitor
