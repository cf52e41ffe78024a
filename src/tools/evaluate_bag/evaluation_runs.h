// Which runs an evaluation has: each backend with each setting.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "tools/evaluate_bag/evaluate_arguments.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {

struct RunSettings {
  std::string backend;  // asked for
  Options options;
};

// What the arguments ask for, or else the parameters. Throws std::invalid_argument at what cannot
// be.
std::vector<RunSettings> runSettings(const EvaluateArguments& arguments,
                                     const MonitorParameters& parameters);

// In the order of the settings. `sources`: as many.
std::vector<std::unique_ptr<EvaluationRun>> makeRuns(
    const std::vector<RunSettings>& settings, std::vector<std::unique_ptr<ContactSource>> sources,
    const MonitorParameters& parameters, const std::vector<Expectation>& expectations);

// Detectors for the runs. Throws std::exceptions, one line, where one cannot do what is asked.
std::vector<std::unique_ptr<ContactSource>> makeDetected(
    const std::vector<RunSettings>& settings, const MonitorParameters& parameters,
    const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
