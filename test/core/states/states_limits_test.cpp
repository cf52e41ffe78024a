// Checks that limits end: what was not decided is open, and never called free.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "scenes.h"
#include "states_fixture.h"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

class StateLimitsSuite : public StatesTest {
 protected:
  StateLimitsSuite() : scene_(pairScene(clothGrid(60, 1, 0, 0.1F), clothGrid(60, 1, 0, 0.1F))) {
    scene_.setMargin(0, 1);
    for (int i = 0; i < 300; ++i) {
      RigidTransform pose;
      pose.translation[2] = 0.003 * i;
      states_.poses.push_back(pose);
    }
  }

  // Expects that each state is open, or as single detections find it, and none of a pair without a
  // decided state is listed.
  void expectPartOf(const StateResults& whole, const StateResults& part) {
    ASSERT_EQ(whole.states.size(), part.states.size());
    std::vector<TouchingBodies> pairs;
    std::size_t open = 0;
    for (std::size_t i = 0; i < whole.states.size(); ++i) {
      if (part.states[i].decision == PairDecision::kOpen) {
        ++open;
        EXPECT_EQ(StateAnswer(), part.states[i]);
      } else {
        EXPECT_EQ(whole.states[i], part.states[i]);
      }
    }
    for (const TouchingBodies& pair : whole.pairs) {
      if (part.states[pair.state].decision != PairDecision::kOpen) pairs.push_back(pair);
    }
    EXPECT_EQ(pairs, part.pairs);
    EXPECT_EQ(open > 0, part.cut_off);
  }

  Scene scene_;
  States states_{{1}, {}};
};

TEST_P(StateLimitsSuite, DecideNothingAfterTheDeadline) {
  StateOptions options;
  options.limits.deadline = Clock::now();
  const StateResults& results = checker_->check(scene_, states_.batch(), options);
  EXPECT_TRUE(results.cut_off);
  EXPECT_EQ(kNoTime, results.cut_off_because);
  for (const StateAnswer& answer : results.states) EXPECT_EQ(StateAnswer(), answer);
  EXPECT_FALSE(checker_->check(scene_, {{1}, 0, nullptr}, options).cut_off);
}

TEST_P(StateLimitsSuite, DecideNothingOnceStopped) {
  StateOptions options;
  const std::atomic<bool> stop{true};
  options.limits.stop = &stop;
  const StateResults& results = checker_->check(scene_, states_.batch(), options);
  EXPECT_TRUE(results.cut_off);
  EXPECT_EQ("stopped", results.cut_off_because);
  for (const StateAnswer& answer : results.states) EXPECT_EQ(StateAnswer(), answer);
}

TEST_P(StateLimitsSuite, AreRightWhereverTheyEnd) {
  StateOptions options;
  options.pairs = options.nearest = true;
  const StateResults whole = checker_->check(scene_, states_.batch(), options);
  EXPECT_FALSE(whole.cut_off);
  for (int us = 1; us < 100000; us *= 2) {
    const auto fresh = GetParam().make();
    for (StateChecker* checker : {checker_.get(), fresh.get()}) {
      options.limits.deadline = Clock::now() + std::chrono::microseconds(us);
      expectPartOf(whole, checker->check(scene_, states_.batch(), options));
    }
    std::atomic<bool> stop{false};
    std::thread stopper([&] {
      std::this_thread::sleep_for(std::chrono::microseconds(us));
      stop = true;
    });
    options.limits = Limits();
    options.limits.stop = &stop;
    expectPartOf(whole, checker_->check(scene_, states_.batch(), options));
    stopper.join();
    options.limits = Limits();
  }
  expectPartOf(whole, checker_->check(scene_, states_.batch(), options));
}

TEST_P(StateLimitsSuite, LeaveAStateOpenIfTheyEndWithinIt) {
  Scene near = pairScene(clothGrid(120, 1, 0, 0.1F), clothGrid(113, 1, 0.02F, 0.1F));
  near.setMargin(0, 1);
  const States one{{1}, {RigidTransform()}};
  StateOptions options;
  options.nearest = options.pairs = true;
  const StateResults whole = checker_->check(near, one.batch(), options);
  ASSERT_EQ(PairDecision::kNear, whole.states[0].decision);
  for (int us = 8; us < 100000; us = us * 5 / 4) {
    options.limits.deadline = Clock::now() + std::chrono::microseconds(us);
    expectPartOf(whole, checker_->check(near, one.batch(), options));
  }
}

INSTANTIATE_TEST_SUITE_P(, StateLimitsSuite, ::testing::ValuesIn(stateBackends()),
                         stateBackendName);

}  // namespace
}  // namespace deformable_contact_monitor
