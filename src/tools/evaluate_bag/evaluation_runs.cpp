// Which runs an evaluation has: each backend with each setting.
#include "tools/evaluate_bag/evaluation_runs.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "cuda/device/cuda_error.h"
#include "tools/common/backend_choice.h"

namespace deformable_contact_monitor {
namespace {

// Unlike the node: what is called cuda ran with CUDA.
std::unique_ptr<Detector> makeBackend(const std::string& backend, const CudaSettings& settings,
                                      const std::function<void(const std::string&)>& warn,
                                      const std::shared_ptr<TilingCache>& tilings) {
  try {
    return makeDetector(backend, WithoutCuda::kRefuse, settings, warn, tilings);
  } catch (const CudaError& error) {
    throw std::runtime_error(std::string(error.what()) + "; --backends cpu needs no GPU");
  }
}

bool hasMargins(const MonitorParameters& parameters) {
  bool any = parameters.margin_m > 0;
  for (const ObjectParameters& object : parameters.objects) any |= object.margin_m > 0;
  for (const auto& [link, margin_m] : parameters.link_margin_m) any |= margin_m > 0;
  return any;
}

StateRules stateRules(const MonitorParameters& parameters) {
  StateRules rules;
  rules.max_age_s = parameters.max_mesh_age_s;
  rules.tolerated_rejects = parameters.tolerated_rejects;
  rules.since_survives_s = parameters.since_survives_s;
  rules.tolerance_m = parameters.detector.tolerance_m;
  rules.debounce_on_cycles = parameters.debounce_on_cycles;
  rules.debounce_off_cycles = parameters.debounce_off_cycles;
  return rules;
}

}  // namespace

std::vector<RunSettings> runSettings(const EvaluateArguments& arguments,
                                     const MonitorParameters& parameters) {
  std::vector<std::string> backends = arguments.backends;
  if (backends.empty()) backends = {toString(parameters.backend)};
  std::vector<Predicates> predicates;
  for (const std::string& name : arguments.predicates) predicates.push_back(toPredicates(name));
  if (predicates.empty()) predicates = {parameters.detector.predicates};
  std::vector<float> overlaps = arguments.overlaps;
  if (overlaps.empty()) overlaps = {parameters.detector.overlap};
  std::vector<RunSettings> all;
  for (const Predicates p : predicates) {
    for (const float overlap : overlaps) {
      for (const std::string& backend : backends) {
        if (parameters.motion == Motion::kSwept && backend == "fcl") {
          throw std::invalid_argument("backend fcl knows no swept motion; set motion to instant");
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

std::vector<std::unique_ptr<EvaluationRun>> makeRuns(
    const std::vector<RunSettings>& settings, std::vector<std::unique_ptr<ContactSource>> sources,
    const MonitorParameters& parameters, const std::vector<Expectation>& expectations) {
  std::vector<std::unique_ptr<EvaluationRun>> runs;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    runs.push_back(std::make_unique<EvaluationRun>(settings[i].backend, std::move(sources.at(i)),
                                                   settings[i].options, stateRules(parameters),
                                                   expectations));
  }
  return runs;
}

std::vector<std::unique_ptr<ContactSource>> makeDetected(
    const std::vector<RunSettings>& settings, const MonitorParameters& parameters,
    const std::function<void(const std::string&)>& warn) {
  std::vector<std::unique_ptr<ContactSource>> sources;
  for (const RunSettings& of : settings) {
    const auto tilings = of.options.tolerance_m > 0 ? std::make_shared<TilingCache>() : nullptr;
    std::unique_ptr<Detector> detector = makeBackend(of.backend, parameters.cuda, warn, tilings);
    if (hasMargins(parameters) && !supportsMargins(*detector)) {
      throw std::invalid_argument("backend " + of.backend + " has no margins; set margin_m to 0");
    }
    sources.push_back(std::make_unique<DetectedContacts>(
        std::move(detector), parameters.containment, parameters.swept_tolerance_m, tilings));
  }
  return sources;
}

}  // namespace deformable_contact_monitor
