// summary.json of an evaluation, and its few lines for people.
#include "tools/evaluate_bag/evaluation_summary.h"

#include <algorithm>
#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/common/json_text.h"
#include "tools/common/machine.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

Json topicsJson(const BagContents& contents) {
  Json json = Json::object();
  for (const auto& [name, topic] : contents.topics) {
    json[name] = {{"type", topic.type}, {"messages", topic.messages}, {"damaged", topic.damaged}};
  }
  return json;
}

Json classesJson(const PairClasses& classes) {
  Json json = Json::array();
  if (classes.robot_deformable) json.push_back("robot_deformable");
  if (classes.deformable_deformable) json.push_back("deformable_deformable");
  if (classes.deformable_self) json.push_back("deformable_self");
  if (classes.robot_self) json.push_back("robot_self");
  return json;
}

bool isSwept(const EvaluationEnd& end) { return end.setup->parameters.motion == Motion::kSwept; }

// What decides which contacts there are.
Json configurationJson(const EvaluationEnd& end) {
  const MonitorParameters& p = end.setup->parameters;
  Json json;
  json["reference_frame"] = p.reference_frame;
  json["robot"] = end.setup->robot_from;
  json["geometry"] = p.geometry.kind == GeometryKind::kCollision ? "collision" : "visual";
  json["links"] = Json::array();
  for (const LinkGeometry& link : end.setup->robot.links) {
    json["links"].push_back({{"name", link.link},
                             {"triangles", link.mesh.triangleCount()},
                             {"source", link.source},
                             {"problem", link.problem}});
  }
  json["margin_m"] = p.margin_m;
  json["link_margin_m"] = p.link_margin_m;
  json["objects"] = Json::array();
  for (const ObjectParameters& object : p.objects) {
    json["objects"].push_back(
        {{"name", object.name}, {"topic", topicOf(object)}, {"margin_m", object.margin_m}});
  }
  json["pair_classes"] = classesJson(p.pair_classes);
  json["allowed_contacts"] = Json::array();
  for (const AllowedContact& rule : p.allowed_contacts.rules()) {
    json["allowed_contacts"].push_back(
        {{"body_a", rule.body_a}, {"body_b", rule.body_b}, {"allowed", rule.allowed != 0}});
  }
  json["adjacent_pairs"] = toString(p.detector.adjacent);
  json["max_mesh_age_s"] = p.max_mesh_age_s;
  if (isSwept(end)) {
    json["motion"] = toString(p.motion);
    json["swept_tolerance_m"] = p.swept_tolerance_m;
  }
  return json;
}

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

Json runJson(const EvaluationRun& run) {
  return {{"name", run.name()},
          {"asked", run.asked},
          {"backend", run.detector->backend()},
          {"predicates", toString(run.options.predicates)},
          {"overlap", run.options.overlap},
          {"cycles", run.cycles},
          {"complete_cycles", run.complete},
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

std::string runLine(const EvaluationRun& run) {
  char line[256];
  std::snprintf(line, sizeof line,
                "%s (on %s): %llu pairs, %llu of %llu cycles complete, detect median %.3f ms, p95 "
                "%.3f ms\n",
                run.name().c_str(), run.detector->backend().c_str(),
                static_cast<unsigned long long>(run.pairs),
                static_cast<unsigned long long>(run.complete),
                static_cast<unsigned long long>(run.cycles), median(run.detect_ms),
                percentile(run.detect_ms, 0.95));
  return line;
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
  json["configuration"] = configurationJson(end);
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
  char line[160];
  std::snprintf(line, sizeof line, "%.1f s; written to %s\n", end.elapsed_s,
                end.arguments->out.c_str());
  return text + line;
}

bool isPassed(const EvaluationEnd& end) {
  const bool agree =
      std::all_of(end.comparisons->begin(), end.comparisons->end(),
                  [](const RunComparison& c) { return !c.must_agree || c.cycles == 0; });
  return agree && std::all_of(end.expectations.begin(), end.expectations.end(),
                              [](const auto& verdict) { return verdict.failure.empty(); });
}

}  // namespace deformable_contact_monitor
