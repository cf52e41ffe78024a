// What the steps that end with a cycle say of each pair of bodies.
#include "monitor/state/step_verdicts.h"

#include <algorithm>
#include <cstdint>

namespace deformable_contact_monitor {
namespace {

// Of the first contact of each pair of bodies.
std::map<std::pair<BodyId, BodyId>, float> firstLows(const DetectionResult& result) {
  std::map<std::pair<BodyId, BodyId>, float> lows;
  auto of_last = lows.end();
  for (std::size_t i = 0; i < result.first_times.size(); ++i) {
    const std::pair<BodyId, BodyId> pair{result.contacts[i].body_a, result.contacts[i].body_b};
    if (of_last == lows.end() || of_last->first != pair)
      of_last = lows.try_emplace(pair, 1.F).first;
    of_last->second = std::min(of_last->second, result.first_times[i].low);
  }
  return lows;
}

}  // namespace

StepVerdicts::StepVerdicts(const CycleReport& report, double tolerated_rejects)
    : report_(report), tolerated_rejects_(tolerated_rejects) {
  for (std::size_t i = 0; i < report.sweeps.size(); ++i) {
    const SweepReport& sweep = report.sweeps[i];
    for (const MonitoredPair& pair : sweep.pairs) step_of_[{pair.a, pair.b}] = i;
    const DetectionResult* const result =
        sweep.result == nullptr ? nullptr : &sweep.result->detection;
    steps_.push_back({PairSummaries(report, result), {}});
    if (result != nullptr) steps_.back().first_low = firstLows(*result);
  }
}

StepVerdict StepVerdicts::of(const MonitoredPair& pair) const {
  StepVerdict verdict;
  const auto found = step_of_.find({pair.a, pair.b});
  if (found == step_of_.end()) return verdict;
  const SweepReport& sweep = report_.sweeps[found->second];
  for (const BodyId id : {pair.a, pair.b}) {
    const std::string& skipped = sweep.bodies[id].skipped;
    if (skipped.empty()) continue;
    verdict.has_step = false;
    verdict.problem = report_.bodies[id].name + ": no step from the previous cycle: " + skipped;
    return verdict;
  }
  const OfStep& step = steps_[found->second];
  verdict.passed = step.touched.of(pair.a, pair.b);
  if (verdict.touched()) {
    const auto low = step.first_low.find({pair.a, pair.b});
    verdict.first_low = low == step.first_low.end() ? 0 : low->second;
  } else {
    verdict.problem = problemOf(sweep, pair);
  }
  return verdict;
}

// Why contacts of the pair may be missing in its step; empty: none is.
std::string StepVerdicts::problemOf(const SweepReport& sweep, const MonitoredPair& pair) const {
  if (sweep.result == nullptr) return "the step's detection failed: " + sweep.problem;
  const DetectionResult& result = sweep.result->detection;
  if (result.cut_off) return "in the step: " + result.cut_off_because;
  if (result.left_out > 0) return "in the step, contacts were left out: memory_limit_mib";
  const std::vector<BodyId>& outlying = sweep.result->outlying;
  for (const BodyId id : {pair.a, pair.b}) {
    if (std::find(outlying.begin(), outlying.end(), id) != outlying.end()) {
      return report_.bodies[id].name + ": in the step, it has vertices too far off to be followed";
    }
    const std::size_t count = report_.scene->body(id).mesh.triangleCount();
    const std::uint64_t rejected = sweep.bodies[id].rejected;
    if (static_cast<double>(rejected) <= tolerated_rejects_ * static_cast<double>(count)) continue;
    return report_.bodies[id].name + ": in the step, " + std::to_string(rejected) + " of " +
           std::to_string(count) +
           " triangles have a vertex that is not finite (tolerated_rejects)";
  }
  return "";
}

}  // namespace deformable_contact_monitor
