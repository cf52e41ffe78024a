// What runs when a backend cannot, or no longer can.
#include "core/fallback_detector.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>

#include "core/cpu/cpu_detector.h"
#include "pair_sets.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// Fails from the `failing`-th cycle on.
class Failing : public Detector {
 public:
  explicit Failing(int failing) : failing_(failing), works_(makeCpuDetector()) {}
  std::string backend() const override { return "failing"; }
  void reset() override {}
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    if (++cycle_ >= failing_) throw std::runtime_error("out of memory");
    return works_->detect(scene, options);
  }

 private:
  int failing_, cycle_ = 0;
  std::unique_ptr<Detector> works_;
};

class Fallback : public testing::Test {
 protected:
  std::unique_ptr<Detector> make(const MakeDetector& first) {
    return makeFallbackDetector(
        first, [] { return makeCpuDetector(); },
        [this](const std::string& why) { warnings_.push_back(why); });
  }
  std::vector<std::string> warnings_;
  Scene scene_ = pairScene(clothGrid(4, 1, 0, 0.1F), clothGrid(3, 1, 0.01F, 0));
};

TEST_F(Fallback, RunsTheFirstWhileItWorks) {
  const auto detector = make([] { return std::make_unique<Failing>(100); });
  EXPECT_EQ(detector->backend(), "failing");
  EXPECT_FALSE(detector->detect(scene_, Options()).contacts.empty());
  EXPECT_EQ(detector->backend(), "failing");
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Fallback, RunsTheSecondWhereTheFirstCannotBeMade) {
  const auto detector =
      make([]() -> std::unique_ptr<Detector> { throw std::runtime_error("no device"); });
  EXPECT_EQ(detector->backend(), "cpu");
  EXPECT_EQ(warnings_, std::vector<std::string>{"no device"});
  EXPECT_FALSE(detector->detect(scene_, Options()).contacts.empty());
  EXPECT_EQ(warnings_.size(), 1U);
}

TEST_F(Fallback, LosesNoCycleWhenTheFirstFails) {
  const auto expected = makeCpuDetector()->detect(scene_, Options()).contacts;
  ASSERT_FALSE(expected.empty());
  const auto detector = make([] { return std::make_unique<Failing>(3); });
  for (int cycle = 1; cycle <= 5; ++cycle) {
    EXPECT_TRUE(samePairs(expected, detector->detect(scene_, Options()).contacts));
    EXPECT_EQ(detector->backend(), cycle < 3 ? "failing" : "cpu");
    EXPECT_EQ(warnings_.size(), cycle < 3 ? 0U : 1U);
  }
  EXPECT_EQ(warnings_[0], "out of memory");
}

TEST_F(Fallback, ACycleThatIsCutOffIsNoReasonToFallBack) {
  const auto detector = make([] { return std::make_unique<Failing>(100); });
  Options options;
  options.limits.deadline = std::chrono::steady_clock::now();
  const DetectionResult& result = detector->detect(scene_, options);
  EXPECT_TRUE(result.cut_off);
  EXPECT_EQ("no time", result.cut_off_because);
  EXPECT_EQ(detector->backend(), "failing");
  EXPECT_TRUE(warnings_.empty());
  EXPECT_FALSE(detector->detect(scene_, Options()).contacts.empty());
}

TEST_F(Fallback, BadOptionsAreNoReasonToFallBack) {
  const auto detector = make([] { return makeCpuDetector(); });
  Options options;
  options.overlap = 2;
  EXPECT_THROW(detector->detect(scene_, options), std::invalid_argument);
  EXPECT_TRUE(warnings_.empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
