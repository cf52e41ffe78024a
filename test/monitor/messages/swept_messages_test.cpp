// Tests the messages that the steps of swept motion become.
#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "monitor/messages/contact_messages.h"
#include "sample_step.h"

namespace deformable_contact_monitor {
namespace {

using Strings = std::vector<std::string>;
using PairList = std::vector<std::array<std::uint32_t, 4>>;

PairList pairsOf(const SweptContacts& message) {
  PairList pairs;
  for (const auto& p : message.pairs) {
    pairs.push_back({p.body_a, p.triangle_a, p.body_b, p.triangle_b});
  }
  return pairs;
}

SweptContacts toMessage(SampleStep* sample, std::size_t max_contacts = 0) {
  return toSweptContacts(sample->report, sample->sweep(), max_contacts);
}

TEST(SweptContactsTest, carriesTheWholeStep) {
  SampleStep sample;
  const SweptContacts message = toMessage(&sample);
  EXPECT_EQ(message.header.stamp, ros::Time(100, 500));
  EXPECT_EQ(message.header.frame_id, "base_link");
  EXPECT_EQ(message.cycle, 7U);
  EXPECT_EQ(message.from_stamp, ros::Time(100, 500) - ros::Duration(0.1));
  EXPECT_EQ(message.bodies, (Strings{"arm/hand", "base", "cloth"}));
  EXPECT_EQ(message.topology_ids, (std::vector<std::uint32_t>{0, 0, 9}));
  EXPECT_EQ(pairsOf(message), (PairList{{0, 0, 2, 0}, {0, 1, 2, 1}}));
  EXPECT_EQ(message.first_low, (std::vector<float>{0.5F, 0.25F}));
  EXPECT_EQ(message.first_high, (std::vector<float>{0.75F, 0.5F}));
  EXPECT_TRUE(message.within_pad.empty());
  EXPECT_EQ(message.pad, 0);
  EXPECT_EQ(message.pair_count, 2U);
  EXPECT_TRUE(message.complete);
  EXPECT_FALSE(message.truncated);
  EXPECT_FALSE(message.timed_out);
  EXPECT_EQ(message.skipped, Strings());
  EXPECT_EQ(message.backend, "cpu");
  EXPECT_EQ(message.predicates, "exact");
  EXPECT_NEAR(message.compute_time.toSec(), 3.5e-3, 1e-9);
  EXPECT_NEAR(message.age.toSec(), 0.25, 1e-9);
}

TEST(SweptContactsTest, padsAreSaidOfEachPair) {
  SampleStep sample;
  sample.step.pad_m = 0.125F;
  sample.step.detection.within_pad = {1, 0};
  const SweptContacts message = toMessage(&sample);
  EXPECT_EQ(message.pad, 0.125F);
  EXPECT_EQ(message.within_pad, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(toMessage(&sample, 1).within_pad, std::vector<std::uint8_t>{1});
}

TEST(SweptContactsTest, truncationKeepsTheFirstPairsAndTheCount) {
  SampleStep sample;
  const SweptContacts cut = toMessage(&sample, 1);
  EXPECT_EQ(pairsOf(cut), (PairList{{0, 0, 2, 0}}));
  EXPECT_EQ(cut.first_low.size(), 1U);
  EXPECT_EQ(cut.first_high.size(), 1U);
  EXPECT_EQ(cut.pair_count, 2U);
  EXPECT_TRUE(cut.truncated);
  EXPECT_FALSE(cut.complete);
  sample.step.pad_m = 1;
  sample.step.detection.within_pad = {0, 0};
  const std::uint64_t all = ros::serialization::serializationLength(toMessage(&sample));
  EXPECT_EQ(toSweptContacts(sample.report, sample.sweep(), 0, all).pairs.size(), 2U);
  EXPECT_EQ(toSweptContacts(sample.report, sample.sweep(), 0, all - 1).pairs.size(), 1U);
}

TEST(SweptContactsTest, whateverIsMissingMakesItIncomplete) {
  const auto complete = [](const std::function<void(SampleStep*)>& change) {
    SampleStep sample;
    change(&sample);
    return toMessage(&sample).complete != 0;
  };
  EXPECT_TRUE(complete([](SampleStep*) {}));
  EXPECT_FALSE(complete([](SampleStep* s) { s->step.detection.guaranteed = false; }));
  EXPECT_FALSE(complete([](SampleStep* s) { s->step.detection.counters.rejected = 1; }));
  EXPECT_FALSE(complete([](SampleStep* s) { s->step.detection.left_out = 1; }));
  EXPECT_FALSE(complete([](SampleStep* s) { s->step.detection.cutOff("stopped"); }));
  EXPECT_FALSE(complete([](SampleStep* s) { s->report.bodies[1].unknown_because = "no TF"; }));
  EXPECT_FALSE(complete([](SampleStep* s) { s->sweep().bodies[1].skipped = "no TF then"; }));
  EXPECT_FALSE(complete([](SampleStep* s) { s->lackStep("reset"); }));
  EXPECT_FALSE(complete([](SampleStep* s) { s->sweep().result = nullptr; }));
}

TEST(SweptContactsTest, whyBodiesHaveNoStepIsSaid) {
  SampleStep none;
  none.lackStep("reset");
  SweptContacts message = toMessage(&none);
  EXPECT_TRUE(message.from_stamp.isZero());
  EXPECT_EQ(message.skipped, Strings{"cloth: reset"});
  EXPECT_EQ(message.topology_ids, (std::vector<std::uint32_t>{0, 0, 0}));
  EXPECT_EQ(message.pair_count, 0U);

  SampleStep unknown;
  unknown.report.bodies[0].unknown_because = "TF is late";
  unknown.sweep().bodies[0].skipped = "not known then";
  unknown.sweep().bodies[1].skipped = "not known then";
  message = toMessage(&unknown);
  EXPECT_EQ(message.skipped, (Strings{"arm/hand: TF is late", "base: not known then"}));

  SampleStep failed;
  failed.sweep().result = nullptr;
  failed.sweep().problem = "no memory";
  failed.sweep().bodies[1].takes_part = false;
  EXPECT_EQ(toMessage(&failed).skipped, (Strings{"arm/hand: the detection failed: no memory",
                                                 "cloth: the detection failed: no memory"}));
}

TEST(SweptContactsTest, timeThatRanOutIsSaid) {
  SampleStep sample;
  sample.step.detection.cutOff(kNoTime);
  EXPECT_TRUE(toMessage(&sample).timed_out);
  EXPECT_TRUE(isOutOfTime(sample.report));
}

}  // namespace
}  // namespace deformable_contact_monitor
