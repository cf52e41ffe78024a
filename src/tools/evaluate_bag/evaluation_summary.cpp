// summary.json of an evaluation, and its few lines for people.
#include "tools/evaluate_bag/evaluation_summary.h"

#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/bags/stamp_text.h"
#include "tools/common/json_text.h"
#include "tools/common/machine.h"
#include "tools/common/run_tool.h"
#include "tools/common/sample_statistics.h"
#include "tools/evaluate_bag/evaluation_configuration.h"
#include "tools/evaluate_bag/evaluation_verdict.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

bool isSwept(const EvaluationEnd& end) { return end.setup->parameters.motion == Motion::kSwept; }

// What the steps of swept motion found.
Json stepsJson(const EvaluationRun& run) {
  const RunSteps::Sums& sums = run.steps.sums();
  return {{"cycles_with_a_step", sums.cycles},
          {"complete_cycles", sums.complete},
          {"pairs", sums.pairs},
          {"pairs_within_pad", sums.within_pad},
          {"passed", sums.passed},
          {"most_pad_m", sums.most_pad_m},
          {"most_sub_steps", sums.most_sub_steps}};
}

Json unknownJson(const EvaluationRun& run) {
  Json json = Json::array();
  for (const UnknownReason& reason : run.unknown.all()) {
    json.push_back({{"reason", reason.text},
                    {"cycles", reason.cycles},
                    {"from", stampText(reason.from)},
                    {"to", stampText(reason.to)}});
  }
  return json;
}

// Which frames TF says, and which joints do.
Json posesJson(const BagContents& contents) {
  Json by_joints = Json::array();
  if (contents.joint_transforms) {
    for (const JointTransforms::Moving& moving : contents.joint_transforms->moving()) {
      if (contents.joints.count(moving.joint) > 0) by_joints.push_back(moving.frame);
    }
    for (const auto& fixed : contents.joint_transforms->fixed()) {
      by_joints.push_back(fixed.child_frame_id);
    }
  }
  return {{"tf_frames", contents.parents.size() - by_joints.size()},
          {"joint_states_frames", by_joints}};
}

Json runJson(const EvaluationRun& run) {
  return {{"name", run.name()},
          {"asked", run.asked},
          {"backend", run.source->backend()},
          {"predicates", toString(run.options.predicates)},
          {"overlap", run.options.overlap},
          {"tolerance_m", run.options.tolerance_m},
          {"cycles", run.cycles},
          {"evaluated_cycles", run.unknown.evaluatedCycles()},
          {"whole_cycles", run.whole},
          {"guaranteed_cycles", run.guaranteed},
          {"complete_cycles", run.complete},
          {"unknown", unknownJson(run)},
          {"pairs", run.pairs}};
}

Json percentiles(const std::vector<double>& ms) {
  return {{"median", median(ms)},
          {"p95", percentile(ms, 0.95)},
          {"p99", percentile(ms, 0.99)},
          {"most", percentile(ms, 1)}};
}

Json timesJson(const EvaluationEnd& end) {
  Json json;
  json["elapsed_s"] = end.elapsed_s;
  const auto& runs = *end.runs;
  const double cycles = runs.empty() ? 0 : static_cast<double>(runs[0]->cycles);
  json["cycles_per_s"] = end.elapsed_s > 0 ? cycles / end.elapsed_s : 0;
  json["runs"] = Json::array();
  for (const auto& run : runs) {
    Json stages = Json::object();
    for (const auto& [name, ms] : run->stages_ms) stages[name] = median(ms);
    json["runs"].push_back({{"name", run->name()},
                            {"detect_ms", percentiles(run->detect_ms)},
                            {"round_trip_ms", percentiles(run->round_trip_ms)},
                            {"median_stages_ms", stages}});
    if (!run->steps.sums().ms.empty()) {
      json["runs"].back()["swept_ms"] = percentiles(run->steps.sums().ms);
    }
  }
  return json;
}

Json comparisonsJson(const EvaluationEnd& end) {
  Json json = Json::array();
  for (const RunComparison& comparison : *end.comparisons) {
    json.push_back({{"first", (*end.runs)[comparison.a]->name()},
                    {"second", (*end.runs)[comparison.b]->name()},
                    {"must_agree", comparison.must_agree},
                    {"cycles_that_differ", comparison.cycles},
                    {"only_first", comparison.only_a},
                    {"only_second", comparison.only_b},
                    {"example", comparison.example}});
  }
  return json;
}

// What no setting of a run guarantees is no failure of its cycles.
std::string cyclesText(const EvaluationRun& run) {
  const std::string of = " of " + std::to_string(run.cycles) + " cycles ";
  if (run.guaranteed == run.cycles) return std::to_string(run.complete) + of + "complete";
  return std::to_string(run.whole) + of + "with nothing left out, but without a guarantee";
}

std::string runLine(const EvaluationRun& run) {
  char times[96];
  std::snprintf(times, sizeof times, ", detect median %.3f ms, p95 %.3f ms\n",
                median(run.detect_ms), percentile(run.detect_ms, 0.95));
  return run.name() + " (on " + run.source->backend() + "): " + std::to_string(run.pairs) +
         " pairs, " + cyclesText(run) + times;
}

constexpr std::size_t kShownReasons = 3;

std::string unknownLines(const EvaluationRun& run) {
  std::string text;
  std::size_t count = 0;
  for (const UnknownReason& reason : run.unknown.all()) {
    if (++count > kShownReasons) continue;
    text += "UNKNOWN in " + std::to_string(reason.cycles) +
            (reason.cycles == 1 ? " cycle: " : " cycles: ") + oneLine(reason.text) + "\n";
  }
  if (count <= kShownReasons) return text;
  return text + "and " + std::to_string(count - kShownReasons) + " more reasons in summary.json\n";
}

std::string stepsLine(const EvaluationRun& run) {
  const RunSteps::Sums& sums = run.steps.sums();
  char line[256];
  std::snprintf(
      line, sizeof line,
      "  between cycles: %llu pairs, %llu passed, %llu of %llu cycles with a step "
      "complete, pads up to %.3g m, median %.3f ms\n",
      static_cast<unsigned long long>(sums.pairs), static_cast<unsigned long long>(sums.passed),
      static_cast<unsigned long long>(sums.complete), static_cast<unsigned long long>(sums.cycles),
      sums.most_pad_m, sums.ms.empty() ? 0.0 : median(sums.ms));
  return line;
}

}  // namespace

std::string summaryJson(const EvaluationEnd& end) {
  Json json;
  json["version"] = DCM_VERSION;
  json["bags"] = end.arguments->files.bags;
  json["topics"] = topicsJson(*end.contents);
  json["problem"] = end.problem;
  json["damaged_messages"] = end.contents->damaged();
  json["refused_transforms"] = end.refused_transforms;
  json["meshes_with_triangles_sent_later"] = end.contents->triangles_ahead.count();
  json["poses"] = posesJson(*end.contents);
  json["configuration"] = configurationJson(*end.setup);
  const boost::uuids::name_generator_sha1 hash(boost::uuids::ns::oid());
  json["configuration_hash"] = to_string(hash(jsonText(json["configuration"])));
  json["cycles"] = end.runs->empty() ? 0 : (*end.runs)[0]->cycles;
  json["runs"] = Json::array();
  for (const auto& run : *end.runs) {
    json["runs"].push_back(runJson(*run));
    if (isSwept(end)) json["runs"].back()["swept"] = stepsJson(*run);
  }
  json["comparisons"] = comparisonsJson(end);
  json["expectations"] = Json::array();
  for (const auto& verdict : end.expectations) {
    json["expectations"].push_back(
        {{"text", verdict.text}, {"holds", verdict.failure.empty()}, {"failure", verdict.failure}});
  }
  json["passed"] = isPassed(end);
  json["verdict"] = verdictText(end);
  json["machine"] = machineJson();
  json["times"] = timesJson(end);
  return jsonText(json);
}

std::string summaryText(const EvaluationEnd& end) {
  std::string text;
  for (const auto& run : *end.runs) {
    text += runLine(*run);
    if (isSwept(end)) text += stepsLine(*run);
  }
  for (const RunComparison& comparison : *end.comparisons) {
    const std::string names =
        (*end.runs)[comparison.a]->name() + " and " + (*end.runs)[comparison.b]->name();
    if (comparison.cycles == 0) {
      text += names + ": the same pairs in every cycle\n";
    } else {
      text += names + (comparison.must_agree ? " DISAGREE" : " differ") + " in " +
              std::to_string(comparison.cycles) + " cycles; " + comparison.example + "\n";
    }
  }
  for (const auto& verdict : end.expectations) {
    text += (verdict.failure.empty() ? "holds: " : "FAILS: ") + verdict.text +
            (verdict.failure.empty() ? "" : " (" + verdict.failure + ")") + "\n";
  }
  if (!end.runs->empty()) text += unknownLines(*(*end.runs)[0]);
  const std::size_t by_joints = posesJson(*end.contents)["joint_states_frames"].size();
  if (by_joints > 0) {
    text += std::to_string(by_joints) + " frames that TF does not have stand where /joint_states " +
            "and the URDF say\n";
  }
  text += verdictText(end) + "\n";
  char line[160];
  std::snprintf(line, sizeof line, "%.1f s; written to %s\n", end.elapsed_s,
                end.arguments->out.c_str());
  return text + line;
}

}  // namespace deformable_contact_monitor
