// The end of an evaluation: whether it passed and why, summary.json, and the lines for people.
//
// The same facts appear three times: in summary.json for programs, on standard output for people,
// and in report.html, which evaluation_report.py draws from the JSON.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_setup.h"
#include "tools/evaluate_bag/evaluate_arguments.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {

// Points to everything that the summary is made of. There is at least one run.
struct EvaluationEnd {
  const EvaluateArguments* arguments = nullptr;
  const BagContents* contents = nullptr;
  const BagSetup* setup = nullptr;
  const std::vector<std::unique_ptr<EvaluationRun>>* runs = nullptr;
  const std::vector<RunComparison>* comparisons = nullptr;
  std::vector<ExpectationJudge::Verdict> expectations;  // of the first run
  std::string problem;                                  // why the bags were not read to their end
  std::string damage;  // `problem`, or which messages could not be read; empty: none
  std::uint64_t refused_transforms = 0;
  std::uint64_t late_cycles = 0;  // BagCycles::lateCycles()
  double elapsed_s = 0;
};

// Returns true if some cycle of the first run has a pair of bodies that is not UNKNOWN.
bool isEvaluated(const EvaluationEnd& end);

// Returns true if something was evaluated, no bag is damaged, runs that must agree do, and all
// expectations hold.
bool isPassed(const EvaluationEnd& end);

// Returns one line, such as "Passed: 2 expectations hold. 5 of 133 cycles had something missing.".
std::string verdictText(const EvaluationEnd& end);

// Returns one line that says why nothing was evaluated, and what to do about it.
std::string whyNothing(const EvaluationEnd& end);

// Returns the content of summary.json. Everything that depends on time or on the machine is under
// "machine" and "times".
std::string summaryJson(const EvaluationEnd& end);

// Returns the lines for standard output.
std::string summaryText(const EvaluationEnd& end);

}  // namespace deformable_contact_monitor
