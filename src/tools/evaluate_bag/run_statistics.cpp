// Sums over the cycles of one run: time intervals of swept motion, and reasons of UNKNOWN.
#include "tools/evaluate_bag/run_statistics.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "tools/common/formatted.h"

namespace deformable_contact_monitor {

// An interval without a beginning belongs to an object's first mesh, and does not count.
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
      if (hasName(cycle.bodies[pair.a], event.body_a) &&
          hasName(cycle.bodies[pair.b], event.body_b)) {
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

// All bodies must be known at the interval's end, and none may have been left out of the interval.
bool isComplete(const CycleReport& cycle, const SweepReport& sweep) {
  if (sweep.from.isZero() || sweep.result == nullptr) return false;
  for (BodyId id = 0; id < cycle.bodies.size(); ++id) {
    const StepBody& body = sweep.bodies[id];
    if (!cycle.bodies[id].unknown_because.empty() || !body.skipped.empty()) return false;
  }
  return sweep.result->detection.isComplete();
}

// A reason counts once in a cycle, however many pairs it affects. Pairs of other objects' cycles do
// not count.
void UnknownReasons::look(const CycleReport& cycle, const ContactStates& states) {
  std::set<std::string> seen;
  bool any_known = false;
  for (std::size_t i = 0; i < statePairCount(cycle); ++i) {
    if (!isOfCycle(cycle.bodies, statePair(cycle, i))) continue;
    const ContactState& state = states.states.at(i);
    any_known |= state.state != ContactState::UNKNOWN;
    if (state.state != ContactState::UNKNOWN) continue;
    const std::string key = withoutNumbers(state.reason);
    if (!seen.insert(key).second) continue;
    UnknownReason& reason = reasons_[key];
    if (reason.cycles++ == 0) {
      reason.text = state.reason;
      reason.from = cycle.header.stamp;
    }
    reason.to = cycle.header.stamp;
  }
  evaluated_ += any_known;
}

std::vector<UnknownReason> UnknownReasons::all() const {
  std::vector<UnknownReason> all;
  for (const auto& [key, reason] : reasons_) all.push_back(reason);
  // Equally frequent reasons stay in the order of their first cycles.
  std::stable_sort(all.begin(), all.end(), [](const UnknownReason& a, const UnknownReason& b) {
    return std::tie(b.cycles, a.from) < std::tie(a.cycles, b.from);
  });
  return all;
}

}  // namespace deformable_contact_monitor
