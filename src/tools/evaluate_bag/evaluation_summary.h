// summary.json of an evaluation, and its few lines for people.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_setup.h"
#include "tools/evaluate_bag/evaluate_arguments.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {

struct EvaluationEnd {
  const EvaluateArguments* arguments = nullptr;
  const BagContents* contents = nullptr;
  const BagSetup* setup = nullptr;
  const std::vector<std::unique_ptr<EvaluationRun>>* runs = nullptr;
  const std::vector<RunComparison>* comparisons = nullptr;
  std::vector<ExpectationJudge::Verdict> expectations;  // of the first run
  std::string problem;                                  // why the bags were not read to their end
  std::uint64_t refused_transforms = 0;
  double elapsed_s = 0;
};

// All that depends on time or on the machine is under "machine" and "times".
std::string summaryJson(const EvaluationEnd& end);

std::string summaryText(const EvaluationEnd& end);

}  // namespace deformable_contact_monitor
