// What an evaluation comes to: passed or not, and why.
#pragma once

#include <string>

#include "tools/evaluate_bag/evaluation_summary.h"

namespace deformable_contact_monitor {

// Whether a cycle of the first run found out about a pair of bodies.
bool isEvaluated(const EvaluationEnd& end);

// Whether there was something to evaluate, runs that must agree do, and all expectations hold.
bool isPassed(const EvaluationEnd& end);

// "Passed: 2 expectations hold. 5 of 133 cycles are not complete.", one line.
std::string verdictText(const EvaluationEnd& end);

// Where nothing was evaluated: why, and what to do about it; one line.
std::string whyNothing(const EvaluationEnd& end);

}  // namespace deformable_contact_monitor
