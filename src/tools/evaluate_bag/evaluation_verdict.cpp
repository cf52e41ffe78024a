// What an evaluation comes to: passed or not, and why.
#include "tools/evaluate_bag/evaluation_verdict.h"

#include <algorithm>

namespace deformable_contact_monitor {
namespace {

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

bool isDisagreement(const RunComparison& c) { return c.must_agree && c.cycles > 0; }

// What was asked for, and how much of it failed.
std::string outcome(const EvaluationEnd& end) {
  const auto must_agree =
      static_cast<std::size_t>(std::count_if(end.comparisons->begin(), end.comparisons->end(),
                                             [](const RunComparison& c) { return c.must_agree; }));
  const auto disagree = static_cast<std::size_t>(
      std::count_if(end.comparisons->begin(), end.comparisons->end(), isDisagreement));
  const auto broken = static_cast<std::size_t>(
      std::count_if(end.expectations.begin(), end.expectations.end(),
                    [](const auto& verdict) { return !verdict.failure.empty(); }));
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (!isPassed(end)) {
    if (broken > 0) add(counted(broken, "expectation fails", "expectations fail"));
    if (disagree > 0) add(counted(disagree, "exact run differs", "exact runs differ"));
    return "Failed: " + text;
  }
  if (!end.expectations.empty()) {
    add(counted(end.expectations.size(), "expectation holds", "expectations hold"));
  }
  if (must_agree > 0) add("exact runs agree");
  return text.empty() ? "Passed, as nothing was asked: no expectations, and no two exact runs"
                      : "Passed: " + text;
}

std::string roots(const BagContents& contents) {
  std::string text;
  for (const std::string& root : contents.rootFrames()) text += (text.empty() ? "" : ", ") + root;
  return text.empty() ? "there are none" : text;
}

std::string advice(const std::string& reason, const BagContents& contents) {
  if (has(reason, "TF ")) {
    return "record /tf and /tf_static together with the meshes, or name a frame of theirs with "
           "--reference-frame (their roots: " +
           roots(contents) + ")";
  }
  if (has(reason, "no triangles of topology_id")) {
    return "record until the publisher sends triangles, as it should once a second";
  }
  return "mend that, and evaluate again";
}

}  // namespace

bool isEvaluated(const EvaluationEnd& end) { return (*end.runs)[0]->unknown.evaluatedCycles() > 0; }

bool isPassed(const EvaluationEnd& end) {
  return isEvaluated(end) &&
         std::none_of(end.comparisons->begin(), end.comparisons->end(), isDisagreement) &&
         std::all_of(end.expectations.begin(), end.expectations.end(),
                     [](const auto& verdict) { return verdict.failure.empty(); });
}

std::string verdictText(const EvaluationEnd& end) {
  if (!isEvaluated(end)) return "Failed: no cycle could be evaluated.";
  const EvaluationRun& first = *(*end.runs)[0];
  std::string text = outcome(end) + ".";
  if (first.whole < first.cycles) {
    text += " " + std::to_string(first.cycles - first.whole) + " of " +
            counted(first.cycles, "cycle", "cycles") + " had something missing.";
  }
  if (first.guaranteed < first.cycles) text += " " + first.name() + " guarantees no set of pairs.";
  return text;
}

std::string whyNothing(const EvaluationEnd& end) {
  const EvaluationRun& run = *(*end.runs)[0];
  if (run.cycles == 0) return "there is no mesh in the bags that can be read";
  const std::vector<UnknownReason> reasons = run.unknown.all();
  if (reasons.empty()) {
    return "there is no pair of bodies to look at: pair_classes must be on, and links or objects "
           "be there, that make one";
  }
  return "in all of " + counted(run.cycles, "cycle", "cycles") +
         " every pair is UNKNOWN (most often: " + reasons[0].text + "); " +
         advice(reasons[0].text, *end.contents);
}

}  // namespace deformable_contact_monitor
