// The grid, the frames and the measuring, with a detector that does what the test tells it.
#include "tools/measure_trade/trade_measurement.h"

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

#include "core/cpu_detector.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// A cloth that sinks onto a floor: no contact in the first two frames, then in all.
class SinkingCloth : public FrameSource {
 public:
  SinkingCloth() {
    scene_.addBody("cloth", clothGrid(6, 1, 0, 0.1F));
    scene_.addBody("floor", clothGrid(2, 1, -1, 0));
    scene_.setPairEnabled(0, 1, true);
  }
  bool next() override {
    if (next_ == kFrames) return false;
    RigidTransform pose;
    pose.translation[2] = next_ < 2 ? 0 : -1 + 0.01 * static_cast<double>(next_);
    scene_.setPose(0, pose);
    ++next_;
    return true;
  }
  bool isDeformable(BodyId body) const override { return body == 0; }
  std::string label() const override { return "frame " + std::to_string(next_ - 1); }

  static constexpr std::size_t kFrames = 5;
};

// The CPU detector's result, changed by `spoil(result, cycle)`.
class SpoiltDetector : public Detector {
 public:
  using Spoil = std::function<void(DetectionResult*, std::size_t)>;
  explicit SpoiltDetector(Spoil spoil) : spoil_(std::move(spoil)) {}
  std::string backend() const override { return "cpu"; }
  void reset() override {}
  void swapResult(DetectionResult& result) override { result_.swap(result); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    result_ = detector_->detect(scene, options);
    spoil_(&result_, cycles_++);
    return result_;
  }

 private:
  std::unique_ptr<Detector> detector_ = makeCpuDetector();
  Spoil spoil_;
  DetectionResult result_;
  std::size_t cycles_ = 0;
};

class TradeMeasurement : public testing::Test {
 protected:
  Measurement measured(const Options& options, const SpoiltDetector::Spoil& spoil,
                       const CycleCounts& cycles = {0, 1}) {
    SpoiltDetector detector(spoil);
    Measurement sum;
    sum.setting = {"cpu", options};
    measure(&frames_, exact_, cycles, &detector, ignore_, &sum);
    return sum;
  }

  const SayProgress ignore_ = [](const std::string&) {};
  SinkingCloth frames_;
  ExactResults exact_ = exactResults(&frames_, AdjacentPairs::kSkip, ignore_);
};

// The warm-up of seven cycles takes two passes of five frames, which are not counted.
TEST_F(TradeMeasurement, CountsWholePassesAfterTheWarmUp) {
  std::vector<std::size_t> counted, others;
  const auto visit = [&counted, &others](std::size_t frame, bool is_counted) {
    (is_counted ? counted : others).push_back(frame);
  };
  forEachCycle(&frames_, {7, 2}, visit);
  const std::vector<std::size_t> twice = {0, 1, 2, 3, 4, 0, 1, 2, 3, 4};
  EXPECT_EQ(twice, counted);
  EXPECT_EQ(twice, others);
}

TEST_F(TradeMeasurement, ExactResultsAreOfEveryFrame) {
  ASSERT_EQ(exact_.labels.size(), SinkingCloth::kFrames);
  EXPECT_EQ(exact_.labels.front(), "frame 0");
  EXPECT_TRUE(exact_.contacts[0].empty() && exact_.contacts[1].empty());
  EXPECT_FALSE(exact_.contacts[2].empty());
  EXPECT_EQ(exact_.bodies, (std::vector<BodyPair>{{0, 1}}));
}

TEST_F(TradeMeasurement, AnExactSettingIsAsGuaranteed) {
  std::size_t cycles = 0;
  const Measurement m =
      measured(Options(), [&](DetectionResult*, std::size_t cycle) { cycles = cycle + 1; }, {7, 3});
  EXPECT_EQ(cycles, 7 + 3 * SinkingCloth::kFrames) << "warm-up goes round the frames";
  EXPECT_EQ(m.round_trip_ms.size(), 3 * SinkingCloth::kFrames);
  EXPECT_EQ(m.broken, "");
  EXPECT_TRUE(m.guaranteed);
  EXPECT_EQ(m.external.worst, 1);
  EXPECT_EQ(m.onset.runs, 3U) << "every pass begins without contact";
  EXPECT_EQ(m.onset.worst, 0U);
  EXPECT_EQ(m.bodies.at({0, 1}).onset.runs, 3U);
}

TEST_F(TradeMeasurement, ABrokenGuaranteeIsSaid) {
  const Measurement lost = measured(Options(), [](DetectionResult* result, std::size_t cycle) {
    if (cycle == 3) result->contacts.pop_back();
  });
  EXPECT_NE(lost.broken.find("misses 1 of the exact contacts and adds 0 in frame 3"),
            std::string::npos)
      << lost.broken;
  EXPECT_FALSE(lost.worth().guaranteed) << "it is not to be chosen for its guarantee";
  const auto add = [](DetectionResult* result, std::size_t cycle) {
    if (cycle == 0) result->contacts.push_back({0, 0, 1, 0});
  };
  EXPECT_NE(measured(Options(), add).broken.find("adds 1 in frame 0"), std::string::npos);
  Options conservative;
  conservative.predicates = Predicates::kConservative;
  const Measurement added = measured(conservative, add);
  EXPECT_EQ(added.broken, "") << "they may add";
  EXPECT_EQ(added.precision.worst, 0);
}

TEST_F(TradeMeasurement, WhatIsNotGuaranteedMayErr) {
  Options hard;
  hard.overlap = 0;
  const Measurement m = measured(hard, [](DetectionResult* result, std::size_t cycle) {
    if (cycle == 2 || cycle == 3) result->contacts.clear();
  });
  EXPECT_EQ(m.broken, "");
  EXPECT_FALSE(m.guaranteed);
  EXPECT_EQ(m.external.worst, 0);
  EXPECT_EQ(m.external.worst_frame, 2U);
  EXPECT_EQ(m.self.worst, 1);
  EXPECT_EQ(m.worth().recall, 0);
  EXPECT_EQ(m.onset.worst, 2U);
  EXPECT_EQ(m.bodies.at({0, 1}).recall.worst_frame, 2U);
}

TEST_F(TradeMeasurement, WhatWasCutOffIsNoMeasurement) {
  EXPECT_THROW(
      measured(Options(), [](DetectionResult* result, std::size_t) { result->cutOff("no time"); }),
      std::runtime_error);
}

TEST_F(TradeMeasurement, ContactsLeftOutAreNoMeasurement) {
  EXPECT_THROW(
      measured(Options(), [](DetectionResult* result, std::size_t) { result->left_out = 1; }),
      std::runtime_error);
}

// A setting that took so long in each of its repeats, and finds a part of the contacts.
Measurement timed(const Setting& setting, const std::vector<double>& ms, double recall = 1) {
  Measurement m;
  m.setting = setting;
  m.round_trip_ms = ms;
  m.repeats.assign(ms.size(), 1);
  m.external.add(recall, 0);
  m.guaranteed = setting.options.overlap == 1;
  return m;
}

TEST(TradeDefaults, AreChosenUnlessAnotherSettingIsFasterBeyondTheNoise) {
  Setting usual{"cpu", Options()}, many = usual, lossy = usual, other_backend = usual;
  many.options.clusters = 64;
  lossy.options.overlap = 0.5F;
  other_backend.backend = "cuda";
  EXPECT_TRUE(isDefault(usual));
  for (const Setting& setting : {many, lossy}) EXPECT_FALSE(isDefault(setting));
  const auto chosen = [](const Measurement& best, const Measurement& defaults,
                         std::optional<double> budget_ms = std::nullopt) {
    return defaultsIfAsGood({best, defaults}, 0, budget_ms);
  };
  const Measurement fast = timed(many, {10, 11, 12});
  EXPECT_EQ(chosen(fast, timed(usual, {11, 12, 13})), 1U);
  EXPECT_EQ(chosen(fast, timed(usual, {13, 14, 15})), 0U) << "they are slower";
  EXPECT_EQ(chosen(fast, timed(usual, {11, 12, 13}, 0.9)), 0U) << "they find less";
  EXPECT_EQ(chosen(fast, timed(other_backend, {11, 12, 13})), 0U) << "they run elsewhere";
  EXPECT_EQ(chosen(fast, timed(usual, {11, 12, 13}), 12.5), 0U) << "they exceed the budget";
  EXPECT_EQ(chosen(fast, timed(usual, {11, 12, 13}), 20), 1U);
  EXPECT_EQ(chosen(timed(lossy, {10, 11, 12}, 0.9), timed(usual, {11, 12, 13})), 1U);
  EXPECT_EQ(chosen(timed(usual, {10, 11, 12}), fast), 0U);
}

TEST(TradeGrid, InFullAndOneAtATime) {
  TradeGrid grid;
  grid.overlaps = {1, 0.5F};
  grid.predicates = {Predicates::kConservative, Predicates::kExact};
  grid.clusters = {0, 8, 8};
  grid.fuzzifiers = {3, 2};
  grid.iterations = {1};
  grid.refresh_periods = {5, 1, 2};
  Options base;
  base.threads = 3;
  const std::vector<Setting> settings = settingsOf(grid, base);
  ASSERT_EQ(settings.size(), 2U * 2 * 2 + 1 + 2);
  std::set<std::string> names;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const Options& options = settings[i].options;
    EXPECT_TRUE(names.insert(describe(settings[i])).second) << describe(settings[i]);
    EXPECT_EQ(options.threads, 3);
    if (i < 8) {
      EXPECT_EQ(options.fuzzifier, 3);
      EXPECT_EQ(options.refresh_period, 5);
    } else {
      EXPECT_EQ(options.overlap, 1);
      EXPECT_EQ(options.predicates, Predicates::kExact);
      EXPECT_EQ(options.clusters, 0);
      EXPECT_EQ((options.fuzzifier != 3) + (options.refresh_period != 5), 1);
    }
  }
  EXPECT_TRUE(
      names.count("cpu, conservative, overlap 0.5, clusters 8, fuzzifier 3, refresh period 5"));
}

}  // namespace
}  // namespace deformable_contact_monitor
