// Tests of the messages that steps become, of their diagnostics and markers.
#include "monitor/messages/swept_messages.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "monitor/diagnostics/motion_watch.h"
#include "monitor/markers/contact_markers.h"
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

std::map<std::string, std::string> described(MotionWatch* watch) {
  diagnostic_updater::DiagnosticStatusWrapper status;
  watch->describe(status);
  std::map<std::string, std::string> values;
  for (const auto& entry : status.values) values[entry.key] = entry.value;
  values["level"] = std::to_string(status.level);
  values["message"] = status.message;
  return values;
}

TEST(MotionWatchTest, countsStepsAndWhatTheyLack) {
  MotionWatch watch;
  SampleStep sample;
  sample.step.sub_steps = 5;
  watch.record(sample.report);
  SampleStep none;
  none.lackStep("reset");
  watch.record(none.report);
  std::map<std::string, std::string> said = described(&watch);
  EXPECT_EQ(said["level"], "0") << "a reset is no fault";
  EXPECT_EQ(said["steps"], "1");
  EXPECT_EQ(said["steps missing or not of all bodies"], "1");
  EXPECT_EQ(said["why the last of them"], "cloth: reset");
  EXPECT_EQ(said["pairs of bodies passed"], "1");
  EXPECT_EQ(said["triangle pairs in the last step"], "2");
  EXPECT_EQ(said["sub-steps of the last step"], "5");

  sample.result.contacts = {{0, 0, 2, 2}};
  watch.record(sample.report);
  EXPECT_EQ(described(&watch)["pairs of bodies passed"], "1") << "in contact at the stamp";
  sample.result.separations_m = {0.5F};
  watch.record(sample.report);
  EXPECT_EQ(described(&watch)["pairs of bodies passed"], "2") << "near";

  sample.step.detection.cutOff(kNoTime);
  watch.record(sample.report);
  EXPECT_EQ(described(&watch)["message"], std::string("a step was cut off: ") + kNoTime);
  EXPECT_EQ(described(&watch)["level"], "0") << "each description looks at its own time";
}

// Triangles by namespace.
std::map<std::string, std::size_t> triangles(const visualization_msgs::MarkerArray& array) {
  std::map<std::string, std::size_t> counts;
  for (const auto& marker : array.markers) {
    if (marker.action == visualization_msgs::Marker::ADD) {
      counts[marker.ns] += marker.points.size() / 3;
    }
  }
  return counts;
}

TEST(PassedMarkersTest, whatPassedHasItsOwn) {
  SampleStep sample;
  ContactMarkers markers((MarkerOptions()));
  EXPECT_EQ(triangles(markers.make(sample.report)),
            (std::map<std::string, std::size_t>{{"cloth", 1}, {"passed: arm/hand/cloth", 4}}));
  sample.result.contacts = {{0, 0, 2, 0}};
  EXPECT_EQ(triangles(markers.make(sample.report)),
            (std::map<std::string, std::size_t>{
                {"arm/hand/cloth", 2}, {"cloth", 1}, {"passed: arm/hand/cloth", 2}}));
  sample.report.sweeps.clear();
  const auto last = markers.make(sample.report);
  EXPECT_EQ(triangles(last),
            (std::map<std::string, std::size_t>{{"arm/hand/cloth", 2}, {"cloth", 2}}));
  bool deleted = false;
  for (const auto& marker : last.markers) {
    deleted = deleted || (marker.ns == "passed: arm/hand/cloth" &&
                          marker.action == visualization_msgs::Marker::DELETE);
  }
  EXPECT_TRUE(deleted);
}

TEST(PassedMarkersTest, theCapHolds) {
  SampleStep sample;
  MarkerOptions options;
  options.max_triangles = 3;
  ContactMarkers markers(options);
  std::size_t all = 0;
  for (const auto& [name, count] : triangles(markers.make(sample.report))) all += count;
  EXPECT_EQ(all, 3U);
}

}  // namespace
}  // namespace deformable_contact_monitor
