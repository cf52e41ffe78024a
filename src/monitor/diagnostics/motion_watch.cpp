// How swept motion goes: steps, what they find, what they lack.
#include "monitor/diagnostics/motion_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <algorithm>
#include <set>
#include <utility>

namespace deformable_contact_monitor {
namespace {

using BodyPairs = std::set<std::pair<BodyId, BodyId>>;

BodyPairs bodyPairs(const DetectionResult& result) {
  BodyPairs pairs;
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    if (!result.separations_m.empty() && result.separations_m[i] > 0) continue;  // near
    pairs.insert({result.contacts[i].body_a, result.contacts[i].body_b});
  }
  return pairs;
}

std::string firstSkipped(const CycleReport& report, const SweepReport& sweep) {
  for (BodyId id = 0; id < sweep.bodies.size(); ++id) {
    const std::string& why = sweep.bodies[id].skipped;
    if (!why.empty()) return report.bodies[id].name + ": " + why;
  }
  return "";
}

}  // namespace

void MotionWatch::record(const CycleReport& report) {
  for (const SweepReport& sweep : report.sweeps) recordStep(report, sweep);
}

void MotionWatch::recordStep(const CycleReport& report, const SweepReport& sweep) {
  const std::string skipped = firstSkipped(report, sweep);
  if (sweep.result == nullptr || !skipped.empty()) {
    ++missing_;
    why_missing_ = skipped.empty() ? sweep.problem : skipped;
  }
  if (sweep.from.isZero()) return;
  if (sweep.result == nullptr) {
    problem_ = "the detection of a step failed";
    return;
  }
  ++steps_;
  const DetectionResult& result = sweep.result->detection;
  if (result.cut_off) problem_ = "a step was cut off: " + result.cut_off_because;
  pairs_ = result.contacts.size() + result.left_out;
  sub_steps_ = sweep.result->sub_steps;
  pad_m_ = sweep.result->pad_m;
  if (report.result == nullptr) return;
  const BodyPairs touching = bodyPairs(*report.result), touched = bodyPairs(result);
  passed_ += static_cast<std::uint64_t>(std::count_if(
      touched.begin(), touched.end(), [&](const auto& pair) { return touching.count(pair) == 0; }));
}

void MotionWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::string problem = std::exchange(problem_, "");
  status.summary(problem.empty() ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                 problem.empty() ? "swept" : problem);
  status.add("steps", steps_);
  status.add("steps missing or not of all bodies", missing_);
  status.add("why the last of them", why_missing_);
  status.add("pairs of bodies passed", passed_);
  status.add("triangle pairs in the last step", pairs_);
  status.add("sub-steps of the last step", sub_steps_);
  status.add("pad of the last step [m]", pad_m_);
}

}  // namespace deformable_contact_monitor
