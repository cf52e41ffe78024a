// Swept motion in an evaluation: what a run finds between the cycles.
#include "tools/evaluate_bag/evaluation_steps.h"

#include <algorithm>

#include "tools/common/completeness.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {

void RunSteps::look(const CycleReport& cycle) {
  sweeps_ = cycle.sweeps;
  bool any = false, complete = true;
  for (const SweepReport& sweep : sweeps_) {
    if (sweep.from.isZero()) continue;
    any = true;
    complete = complete && isComplete(cycle, sweep);
    if (sweep.result == nullptr) continue;
    const std::vector<std::uint8_t>& pads = sweep.result->detection.within_pad;
    sums_.within_pad +=
        static_cast<std::uint64_t>(std::count(pads.begin(), pads.end(), std::uint8_t{1}));
    sums_.most_pad_m = std::max(sums_.most_pad_m, double{sweep.result->pad_m});
    sums_.most_sub_steps = std::max(sums_.most_sub_steps, sweep.result->sub_steps);
  }
  if (!any) return;
  ++sums_.cycles;
  sums_.complete += complete;
  sums_.pairs += pairsOfCycle();
  sums_.ms.push_back(msOfCycle());
}

void RunSteps::takeEvents(ContactStateTracker* tracker) {
  events_ = tracker->takeEvents();
  for (const ContactEvent& event : events_) sums_.passed += event.type == ContactEvent::PASSED;
}

ros::Time RunSteps::beginningOf(const CycleReport& cycle, const ContactEvent& event) const {
  for (const SweepReport& sweep : sweeps_) {
    for (const MonitoredPair& pair : sweep.pairs) {
      if (cycle.bodies[pair.a].name == event.body_a && cycle.bodies[pair.b].name == event.body_b) {
        return sweep.from;
      }
    }
  }
  return ros::Time();
}

std::uint64_t RunSteps::pairsOfCycle() const {
  std::uint64_t pairs = 0;
  for (const SweepReport& sweep : sweeps_) {
    if (sweep.result == nullptr) continue;
    const DetectionResult& result = sweep.result->detection;
    pairs += result.contacts.size() + result.left_out;
  }
  return pairs;
}

bool RunSteps::isCycleComplete(const CycleReport& cycle) const {
  return std::all_of(sweeps_.begin(), sweeps_.end(),
                     [&cycle](const SweepReport& sweep) { return isComplete(cycle, sweep); });
}

double RunSteps::msOfCycle() const {
  double ms = 0;
  for (const SweepReport& sweep : sweeps_) ms += 1e3 * sweep.compute_s;
  return ms;
}

bool isComplete(const CycleReport& cycle, const SweepReport& sweep) {
  if (sweep.from.isZero() || sweep.result == nullptr) return false;
  for (BodyId id = 0; id < cycle.bodies.size(); ++id) {
    const StepBody& body = sweep.bodies[id];
    if (!cycle.bodies[id].unknown_because.empty() || !body.skipped.empty()) return false;
  }
  return isComplete(sweep.result->detection);
}

SetDifference difference(const Scene& scene, const RunSteps& a, const RunSteps& b) {
  static const DetectionResult kNothing;
  const auto result_of = [](const SweepReport& sweep) -> const DetectionResult& {
    return sweep.result == nullptr ? kNothing : sweep.result->detection;
  };
  SetDifference all;
  for (std::size_t i = 0; i < a.sweeps().size(); ++i) {
    SetDifference found = difference(scene, result_of(a.sweeps()[i]), result_of(b.sweeps()[i]));
    if (!found.isEmpty()) found.example = "in the step, " + found.example;
    all.add(found);
  }
  return all;
}

}  // namespace deformable_contact_monitor
