// One run of an evaluation: a backend with one setting, through all cycles of the bags.
//
// An evaluation has one run for each combination of backend, predicates and overlap. All runs see
// the same cycles, and the contacts of each run are compared with those of the first as sets.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/detector.h"
#include "core/tiling_cache.h"
#include "monitor/cycle/cycle_detection.h"
#include "monitor/cycle_report.h"
#include "monitor/rules/parameters.h"
#include "monitor/state/contact_state_tracker.h"
#include "tools/evaluate_bag/evaluate_arguments.h"
#include "tools/evaluate_bag/expectations.h"
#include "tools/evaluate_bag/run_statistics.h"

namespace deformable_contact_monitor {

// Returns a run's name, such as "cpu exact", "cuda exact, overlap 0.5" or "fcl". `asked` is the
// backend that was asked for; another one may have run.
std::string runName(const std::string& asked, const Options& options);

// Returns true if any body has a margin, so that `near_pairs` lists pairs at a distance. FCL
// cannot.
bool hasMargins(const MonitorParameters& parameters);

// The state and the sums of one run, which finds contacts as the node does on live meshes.
struct EvaluationRun {
  // `looks_within`: also find which bodies lie within others. `swept_tolerance_m`: how far a link's
  // path may be from its true one, as CycleDetection takes it [m]. `with_tilings`: tilings of a
  // detector with a tolerance, built before each cycle; null: the detector is exact.
  EvaluationRun(std::string asked_for, std::unique_ptr<Detector> with_detector, const Options& with,
                const StateRules& rules, std::vector<Expectation> expectations,
                bool looks_within = false, double swept_tolerance_m = 0,
                std::shared_ptr<TilingCache> with_tilings = nullptr);

  // Finds the cycle's contacts, fills the report, and updates everything below. The report must be
  // as BagCycles made it; `scene` is the report's. `at_edge`: see ExpectationJudge.
  void evaluate(CycleReport* cycle, Scene* scene, bool at_edge = false);

  // Forgets all states, because of `reason`. The sums stay.
  void forget(const std::string& reason, const ros::Time& now);

  // Returns the name in tables and reports.
  std::string name() const { return runName(asked, options); }

  const std::string asked;  // the backend
  const std::unique_ptr<Detector> detector;
  const std::shared_ptr<TilingCache> tilings;
  CycleDetection detection;
  const Options options;
  ContactStateTracker tracker;
  ExpectationJudge judge;
  RunSteps steps;
  UnknownReasons unknown;

  // These describe the latest cycle.
  std::shared_ptr<const DetectionResult> result;
  ContactStates states;

  // These are sums over all cycles.
  std::uint64_t cycles = 0, pairs = 0;
  std::uint64_t whole = 0;       // cycles in which nothing was left out
  std::uint64_t guaranteed = 0;  // cycles whose setting and backend find every pair by proof
  std::uint64_t complete = 0;    // cycles that are both
  std::vector<double> detect_ms, round_trip_ms;
  std::vector<std::pair<std::string, std::vector<double>>> stages_ms;  // in order of execution
};

// Returns true if the run's contacts depend on the cycle alone, not on settings or earlier cycles.
// All such runs must find the same set of pairs.
bool isExact(const EvaluationRun& run);

// Returns true if every body and triangle took part and no contact was left out.
bool isWhole(const CycleReport& cycle, const DetectionResult& result);

// Returns true if no contact can be missing, as ContactArray.complete defines it.
bool isComplete(const CycleReport& cycle, const DetectionResult& result);

// How the contacts of two runs differ in a cycle, as sets.
struct SetDifference {
  std::uint64_t only_a = 0, only_b = 0;
  std::string example;  // the first pair that only one of them has

  // Returns true if both runs have the same pairs.
  bool isEmpty() const { return only_a == 0 && only_b == 0; }
  // Adds the difference of another set; the first example stays.
  void add(const SetDifference& o) {
    only_a += o.only_a;
    only_b += o.only_b;
    if (example.empty()) example = o.example;
  }
};

// Compares the contacts of two runs in the latest cycle. Names come from the scene. What a run left
// out for want of memory explains as many contacts that only the other one lists.
SetDifference difference(const Scene& scene, const DetectionResult& a, const DetectionResult& b);

// Compares the contacts of two runs' time intervals in the latest cycle. An interval that one run
// has no result for counts as one without contacts.
SetDifference difference(const Scene& scene, const RunSteps& a, const RunSteps& b);

// Two runs, compared over all cycles.
struct RunComparison {
  std::size_t a = 0, b = 0;  // indices of the runs
  // Both runs are exact, so a difference is a defect. Otherwise settings may explain it.
  bool must_agree = false;
  std::uint64_t cycles = 0;  // cycles in which they differ
  SetDifference found;       // over all cycles; the example has the stamp of its cycle
};

// Returns a comparison of every other run with the first.
std::vector<RunComparison> comparisons(const std::vector<std::unique_ptr<EvaluationRun>>& runs);

// The backend and the options of a run.
struct RunSettings {
  std::string backend;  // the one that was asked for
  Options options;
};

// Returns what the command line asks for, or else what the parameters say. Throws
// std::invalid_argument, one line, if a combination is not supported.
std::vector<RunSettings> runSettings(const EvaluateArguments& arguments,
                                     const MonitorParameters& parameters);

// Makes a run for each setting, in their order. Throws std::exception, one line, if a backend
// cannot do what is asked. `warn` gets what a user should know.
std::vector<std::unique_ptr<EvaluationRun>> makeRuns(
    const std::vector<RunSettings>& settings, const MonitorParameters& parameters,
    const std::vector<Expectation>& expectations,
    const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
