// One backend with one setting, through all cycles of an evaluation.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/detector.h"
#include "monitor/cycle_report.h"
#include "monitor/state/contact_state_tracker.h"
#include "tools/evaluate_bag/contact_source.h"
#include "tools/evaluate_bag/evaluation_steps.h"
#include "tools/evaluate_bag/expectations.h"
#include "tools/evaluate_bag/unknown_reasons.h"

namespace deformable_contact_monitor {

// "cpu exact", "cuda exact, overlap 0.5", "fcl": what was asked for, which is not always what ran.
std::string runName(const std::string& asked, const Options& options);

struct EvaluationRun {
  EvaluationRun(std::string asked_for, std::unique_ptr<ContactSource> from, const Options& with,
                const StateRules& rules, std::vector<Expectation> expectations);

  // Finds the cycle's contacts, and fills the report; `scene` is the report's.
  void find(CycleReport* cycle, Scene* scene);

  // find(), and keeps what came of it: times, states, and all that is counted.
  void evaluate(CycleReport* cycle, Scene* scene);

  std::string name() const { return runName(asked, options); }

  const std::string asked;  // backend
  const std::unique_ptr<ContactSource> source;
  const Options options;
  ContactStateTracker tracker;
  ExpectationJudge judge;
  RunSteps steps;
  UnknownReasons unknown;

  // Of the latest cycle.
  const DetectionResult* result = nullptr;
  ContactStates states;

  // Of all cycles.
  std::uint64_t cycles = 0, pairs = 0;
  // Cycles in which nothing was left out, whose setting and backend are complete by proof, and
  // both.
  std::uint64_t whole = 0, guaranteed = 0, complete = 0;
  std::vector<double> detect_ms, round_trip_ms;
  std::vector<std::pair<std::string, std::vector<double>>> stages_ms;  // in order of execution
};

// Whose contacts are those of the definition, whatever came before, when the settings are.
bool isExact(const EvaluationRun& run);

// Whether every body and triangle took part and no contact was left out.
bool isWhole(const CycleReport& cycle, const DetectionResult& result);

// Whether nothing can be missing: as ContactArray.complete says it.
bool isComplete(const CycleReport& cycle, const DetectionResult& result);

// How two runs' contacts differ in a cycle, as sets.
struct SetDifference {
  std::uint64_t only_a = 0, only_b = 0;
  std::string example;  // the first pair that only one has

  bool isEmpty() const { return only_a == 0 && only_b == 0; }
  void add(const SetDifference& o) {
    only_a += o.only_a;
    only_b += o.only_b;
    if (example.empty()) example = o.example;
  }
};

SetDifference difference(const Scene& scene, const DetectionResult& a, const DetectionResult& b);

// Two runs over all cycles.
struct RunComparison {
  std::size_t a = 0, b = 0;  // of the runs
  // Both are exact by design, so that a difference is a defect; else it is a matter of settings.
  bool must_agree = false;
  std::uint64_t cycles = 0;              // in which they differ
  std::uint64_t only_a = 0, only_b = 0;  // pairs, of all cycles
  std::string example;                   // of the first cycle that differs, with its stamp
};

// Every run with the first.
std::vector<RunComparison> comparisons(const std::vector<std::unique_ptr<EvaluationRun>>& runs);

}  // namespace deformable_contact_monitor
