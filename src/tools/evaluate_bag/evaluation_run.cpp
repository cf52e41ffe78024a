// Runs one backend with one setting through the cycles of a bag, and compares runs. A run uses the
// classes of the live node (CycleDetection, ContactStateTracker), so its states are the node's.
#include "tools/evaluate_bag/evaluation_run.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "cuda/device/cuda_error.h"
#include "tools/common/backend_choice.h"

namespace deformable_contact_monitor {
namespace {

// Returns a pair in words, as examples in reports show it.
std::string shown(const Scene& scene, const TrianglePair& pair) {
  std::ostringstream text;
  text << scene.body(pair.body_a).name << " " << pair.triangle_a << ", "
       << scene.body(pair.body_b).name << " " << pair.triangle_b;
  return text.str();
}

// Adds the times of a cycle's stages. A stage that runs twice in a cycle counts once, with the sum.
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

// Makes a detector that never falls back to the CPU. The node would; but a run that is called
// "cuda" must have run with CUDA, or the comparison would compare the CPU with itself.
std::unique_ptr<Detector> makeBackend(const std::string& backend, const CudaSettings& settings,
                                      const std::function<void(const std::string&)>& warn,
                                      const std::shared_ptr<TilingCache>& tilings) {
  try {
    return makeDetector(backend, WithoutCuda::kRefuse, settings, warn, tilings);
  } catch (const CudaError& error) {
    throw std::runtime_error(std::string(error.what()) + "; --backends cpu needs no GPU");
  }
}

// Returns whether the cycle and its steps list every contact of the triangles that there are.
bool foundAll(const CycleReport& cycle, const DetectionResult& result) {
  return result.isWhole() &&
         std::all_of(cycle.sweeps.begin(), cycle.sweeps.end(), [](const SweepReport& sweep) {
           return sweep.result == nullptr || sweep.result->detection.isWhole();
         });
}

}  // namespace

bool hasMargins(const MonitorParameters& parameters) {
  bool any = parameters.margin_m > 0;
  for (const ObjectParameters& object : parameters.objects) {
    any |= object.margin_m > 0;
    for (const PartParameters& part : object.parts) any |= part.margin_m.value_or(0) > 0;
  }
  for (const RigidParameters& rigid : parameters.rigids) any |= rigid.margin_m > 0;
  for (const auto& [link, margin_m] : parameters.link_margin_m) any |= margin_m > 0;
  return any;
}

EvaluationRun::EvaluationRun(std::string asked_for, std::unique_ptr<Detector> with_detector,
                             const Options& with, const StateRules& rules,
                             std::vector<Expectation> expectations, bool looks_within,
                             double swept_tolerance_m, std::shared_ptr<TilingCache> with_tilings)
    : asked(std::move(asked_for)),
      detector(std::move(with_detector)),
      tilings(std::move(with_tilings)),
      detection(*detector, {looks_within, swept_tolerance_m, false}),
      options(with),
      tracker(rules),
      judge(std::move(expectations), rules.max_age_s) {}

// All runs share the report, so what an earlier run left in it is cleared first.
void EvaluationRun::evaluate(CycleReport* cycle, Scene* scene, bool at_edge) {
  cycle->options = options;
  cycle->backend = detector->backend();
  cycle->containment = nullptr;
  for (SweepReport& sweep : cycle->sweeps) {
    sweep.result = nullptr;
    sweep.problem.clear();
    for (StepBody& body : sweep.bodies) body.rejected = 0;
  }
  // The node builds tilings while it detects; here each cycle waits for them, so that no state
  // depends on how fast that is.
  if (tilings != nullptr) makeTilings(*scene, tilings.get());
  detection.run(Limits(), false, scene, cycle);
  result = cycle->result;
  steps.look(*cycle);
  const ros::Time& stamp = cycle->header.stamp;
  tracker.expire(stamp, "no new mesh within max_mesh_age_s");
  tracker.update(*cycle);
  states = tracker.states(stamp, stamp);
  steps.takeEvents(&tracker);
  judge.look(states, at_edge, foundAll(*cycle, *result));
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

void EvaluationRun::forget(const std::string& reason, const ros::Time& now) {
  detector->reset();
  tracker.forget("", reason, now);
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

// FCL decides in floating point, so its contacts may differ from the exact ones.
bool isExact(const EvaluationRun& run) {
  return run.asked != "fcl" && run.options.predicates == Predicates::kExact &&
         run.options.overlap == 1 && run.options.tolerance_m == 0;
}

bool isComplete(const CycleReport& cycle, const DetectionResult& result) {
  return isWhole(cycle, result) && result.isComplete();
}

// A body without a usable mesh or transform took no part, so its contacts are missing.
bool isWhole(const CycleReport& cycle, const DetectionResult& result) {
  return result.isWhole() &&
         std::all_of(cycle.bodies.begin(), cycle.bodies.end(),
                     [](const BodyStatus& body) { return body.unknown_because.empty(); });
}

namespace {

// Takes back differences that a list explains because it had no room for all contacts: what only
// the other one has may be among those. The numbers of all contacts must be equal nevertheless.
void excuse(const DetectionResult& a, const DetectionResult& b, SetDifference* found) {
  if (a.left_out == 0 && b.left_out == 0) return;
  found->only_a -= std::min(found->only_a, b.left_out);
  found->only_b -= std::min(found->only_b, a.left_out);
  if (!found->isEmpty()) return;
  const std::uint64_t all_a = a.contacts.size() + a.left_out;
  const std::uint64_t all_b = b.contacts.size() + b.left_out;
  found->only_a = all_a - std::min(all_a, all_b);
  found->only_b = all_b - std::min(all_a, all_b);
  found->example.clear();
  if (all_a != all_b) {
    found->example = "the first has " + std::to_string(all_a) + " contacts, the second " +
                     std::to_string(all_b) + ", not all of them listed";
  }
}

}  // namespace

// Both lists are sorted, so one pass finds what only one of them has.
SetDifference difference(const Scene& scene, const DetectionResult& a, const DetectionResult& b) {
  SetDifference found;
  // Counts a pair that only one has, and keeps the first as an example.
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
  excuse(a, b, &found);
  return found;
}

SetDifference difference(const Scene& scene, const RunSteps& a, const RunSteps& b) {
  // Stands for the result of an interval that a run has none of.
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

// A difference is a defect only between two exact runs.
std::vector<RunComparison> comparisons(const std::vector<std::unique_ptr<EvaluationRun>>& runs) {
  std::vector<RunComparison> all;
  for (std::size_t i = 1; i < runs.size(); ++i) {
    all.push_back({0, i, isExact(*runs[0]) && isExact(*runs[i]), 0, {}});
  }
  return all;
}

std::vector<RunSettings> runSettings(const EvaluateArguments& arguments,
                                     const MonitorParameters& parameters) {
  // Each empty list stands for the configuration's value.
  std::vector<std::string> backends = arguments.backends;
  if (backends.empty()) backends = {toString(parameters.backend)};
  std::vector<Predicates> predicates;
  for (const std::string& name : arguments.predicates) predicates.push_back(toPredicates(name));
  if (predicates.empty()) predicates = {parameters.detector.predicates};
  std::vector<float> overlaps = arguments.overlaps;
  if (overlaps.empty()) overlaps = {parameters.detector.overlap};
  std::vector<RunSettings> all;
  // Backends vary fastest, so that runs which should agree stand next to each other in reports.
  for (const Predicates p : predicates) {
    for (const float overlap : overlaps) {
      for (const std::string& backend : backends) {
        if (parameters.motion == Motion::kSwept && backend == "fcl") {
          throw std::invalid_argument(
              "backend fcl does not support swept motion; set motion to instant");
        }
        all.push_back({backend, parameters.detector});
        all.back().options.predicates = p;
        all.back().options.overlap = overlap;
        if (arguments.threads) all.back().options.threads = *arguments.threads;
      }
    }
  }
  return all;
}

// Each run has its own detector and tilings, because both keep a warm start of their own setting.
std::vector<std::unique_ptr<EvaluationRun>> makeRuns(
    const std::vector<RunSettings>& settings, const MonitorParameters& parameters,
    const std::vector<Expectation>& expectations,
    const std::function<void(const std::string&)>& warn) {
  std::vector<std::unique_ptr<EvaluationRun>> runs;
  for (const RunSettings& of : settings) {
    const auto tilings = of.options.tolerance_m > 0 ? std::make_shared<TilingCache>() : nullptr;
    std::unique_ptr<Detector> detector = makeBackend(of.backend, parameters.cuda, warn, tilings);
    if (of.options.near_pairs && hasMargins(parameters) && !supportsMargins(*detector)) {
      throw std::invalid_argument("backend " + of.backend +
                                  " does not support near_pairs; set it to false");
    }
    runs.push_back(std::make_unique<EvaluationRun>(
        of.backend, std::move(detector), of.options, stateRules(parameters), expectations,
        parameters.containment, parameters.swept_tolerance_m, tilings));
  }
  return runs;
}

}  // namespace deformable_contact_monitor
