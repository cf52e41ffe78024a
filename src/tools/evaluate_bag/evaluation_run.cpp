// One backend with one setting, through all cycles of an evaluation.
#include "tools/evaluate_bag/evaluation_run.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "tools/common/completeness.h"

namespace deformable_contact_monitor {
namespace {

std::string shown(const Scene& scene, const TrianglePair& pair) {
  std::ostringstream text;
  text << scene.body(pair.body_a).name << " " << pair.triangle_a << ", "
       << scene.body(pair.body_b).name << " " << pair.triangle_b;
  return text.str();
}

void addStages(const DetectionResult& result, std::size_t cycles, EvaluationRun* run) {
  for (const auto& [name, ms] : result.stages_ms) {
    auto found = std::find_if(run->stages_ms.begin(), run->stages_ms.end(),
                              [&name = name](const auto& stage) { return stage.first == name; });
    if (found == run->stages_ms.end()) {
      found = run->stages_ms.insert(found, {name, {}});
    }
    found->second.resize(cycles);  // cycles that left the stage out took no time in it
    found->second.back() += ms;
  }
}

}  // namespace

EvaluationRun::EvaluationRun(std::string asked_for, std::unique_ptr<ContactSource> from,
                             const Options& with, const StateRules& rules,
                             std::vector<Expectation> expectations)
    : asked(std::move(asked_for)),
      source(std::move(from)),
      options(with),
      tracker(rules),
      judge(std::move(expectations)) {}

void EvaluationRun::find(CycleReport* cycle, Scene* scene) {
  cycle->options = options;
  cycle->backend = source->backend();
  cycle->containment = nullptr;
  for (SweepReport& sweep : cycle->sweeps) {  // another run's
    sweep.result = nullptr;
    sweep.problem.clear();
    for (StepBody& body : sweep.bodies) body.rejected = 0;
  }
  source->find(scene, cycle);
  result = cycle->result;
}

void EvaluationRun::evaluate(CycleReport* cycle, Scene* scene) {
  find(cycle, scene);
  noteRejected(cycle);
  steps.look(*cycle);
  const ros::Time& stamp = cycle->header.stamp;
  tracker.expire(stamp, "no new mesh within max_mesh_age_s");
  tracker.update(*cycle);
  states = tracker.states(stamp, stamp);
  steps.takeEvents(&tracker);
  judge.look(states);
  unknown.look(*cycle, states);
  ++cycles;
  whole += isWhole(*cycle, *result);
  guaranteed += result->guaranteed;
  complete += isComplete(*cycle, *result);
  pairs += result->contacts.size() + result->left_out;
  detect_ms.push_back(result->detect_ms);
  round_trip_ms.push_back(result->round_trip_ms);
  addStages(*result, cycles, this);
}

std::string runName(const std::string& asked, const Options& options) {
  std::ostringstream text;
  text << asked;
  if (asked == "fcl") return text.str();  // it has predicates of its own
  text << " " << toString(options.predicates);
  if (options.overlap != 1) text << ", overlap " << options.overlap;
  if (options.tolerance_m > 0) text << ", tolerance " << options.tolerance_m << " m";
  return text.str();
}

bool isExact(const EvaluationRun& run) {
  return run.asked != "fcl" && run.options.predicates == Predicates::kExact &&
         run.options.overlap == 1 && run.options.tolerance_m == 0;
}

bool isComplete(const CycleReport& cycle, const DetectionResult& result) {
  return isWhole(cycle, result) && isComplete(result);
}

bool isWhole(const CycleReport& cycle, const DetectionResult& result) {
  return isWhole(result) &&
         std::all_of(cycle.bodies.begin(), cycle.bodies.end(),
                     [](const BodyStatus& body) { return body.unknown_because.empty(); });
}

SetDifference difference(const Scene& scene, const DetectionResult& a, const DetectionResult& b) {
  SetDifference found;
  const auto add = [&](const TrianglePair& pair, std::uint64_t* count, const char* who) {
    ++*count;
    if (found.example.empty()) found.example = std::string(who) + ": " + shown(scene, pair);
  };
  auto in_a = a.contacts.begin();
  auto in_b = b.contacts.begin();
  while (in_a != a.contacts.end() || in_b != b.contacts.end()) {
    if (in_b == b.contacts.end() || (in_a != a.contacts.end() && *in_a < *in_b)) {
      add(*in_a++, &found.only_a, "only the first has");
    } else if (in_a == a.contacts.end() || *in_b < *in_a) {
      add(*in_b++, &found.only_b, "only the second has");
    } else {
      ++in_a;
      ++in_b;
    }
  }
  return found;
}

std::vector<RunComparison> comparisons(const std::vector<std::unique_ptr<EvaluationRun>>& runs) {
  std::vector<RunComparison> all;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    all.push_back({0, i, isExact(*runs[0]) && isExact(*runs[i]), 0, 0, 0, ""});
  }
  return all;
}

}  // namespace deformable_contact_monitor
