// Decides whether an evaluation passed, and writes its summary. Each function that ends in Json
// fills one part of summary.json. The parts that differ from one evaluation to the next stand
// apart, so that two files can be compared.
#include "tools/evaluate_bag/evaluation_summary.h"

#include <algorithm>
#include <boost/algorithm/cxx11/any_of.hpp>
#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <nlohmann/json.hpp>

#include "tools/common/command_line.h"
#include "tools/common/formatted.h"
#include "tools/common/reports.h"
#include "tools/common/run_tool.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

// Returns a number with the singular or plural of a word.
std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

// Two exact runs must find the same pairs; if not, one of them has a defect.
bool isDisagreement(const RunComparison& c) { return c.must_agree && c.cycles > 0; }

// Says what was asked for, or how much of it failed.
std::string outcome(const EvaluationEnd& end) {
  // Counts what was asked for first, because the text depends on it.
  const auto must_agree =
      static_cast<std::size_t>(std::count_if(end.comparisons->begin(), end.comparisons->end(),
                                             [](const RunComparison& c) { return c.must_agree; }));
  const auto disagree = static_cast<std::size_t>(
      std::count_if(end.comparisons->begin(), end.comparisons->end(), isDisagreement));
  const auto broken = static_cast<std::size_t>(
      std::count_if(end.expectations.begin(), end.expectations.end(),
                    [](const auto& verdict) { return !verdict.failure.empty(); }));
  std::vector<std::string> parts;
  if (broken > 0) parts.push_back(counted(broken, "expectation fails", "expectations fail"));
  if (disagree > 0) parts.push_back(counted(disagree, "exact run differs", "exact runs differ"));
  if (!end.damage.empty()) {
    parts.emplace_back("a bag is damaged");
    if (parts.size() == 1) return "Not judged: " + parts[0];
  }
  if (!parts.empty()) return "Failed: " + joined(parts, ", ");
  if (!end.expectations.empty()) {
    parts.push_back(counted(end.expectations.size(), "expectation holds", "expectations hold"));
  }
  if (must_agree > 0) parts.emplace_back("exact runs agree");
  return parts.empty() ? "Passed, as nothing was asked: no expectations, and no two exact runs"
                       : "Passed: " + joined(parts, ", ");
}

// Returns what a user can do about the most frequent reason of UNKNOWN.
std::string advice(const std::string& reason, const BagContents& contents) {
  if (has(reason, "set frame_prefix")) return "give --frame-prefix, or set it in --config";
  if (has(reason, "set reference_frame")) return "give --reference-frame, or set it in --config";
  if (has(reason, "TF ")) {
    const BagTopics& chosen = contents.chosen;
    std::string hints = chosen.other_transforms;
    if (!chosen.other_joint_states.empty()) {
      hints += (hints.empty() ? "" : "; ") + chosen.other_joint_states;
    }
    if (!hints.empty()) return hints;
    const std::set<std::string> roots = contents.rootFrames();  // good reference frames
    return "record /tf and /tf_static together with the meshes, or name a frame of theirs with "
           "--reference-frame (their roots: " +
           (roots.empty() ? "there are none" : joined(roots, ", ")) + ")";
  }
  if (has(reason, "no triangles of topology_id")) {
    return "record until the publisher sends triangles, as it should once a second";
  }
  return "mend that, and evaluate again";
}

// Lists the bags' topics with their types and numbers of messages.
Json topicsJson(const BagContents& contents) {
  Json json = Json::object();
  for (const auto& [name, topic] : contents.topics) {
    json[name] = {{"type", topic.type}, {"messages", topic.messages}, {"damaged", topic.damaged}};
  }
  return json;
}

// Lists everything that decides which contacts there are. Its hash identifies the configuration.
Json configurationJson(const BagSetup& setup) {
  const MonitorParameters& p = setup.parameters;
  Json json;
  json["reference_frame"] = p.reference_frame;
  if (!p.frame_prefix.empty()) json["frame_prefix"] = p.frame_prefix;
  json["robot"] = setup.robot_from;
  json["geometry"] = kGeometryKinds.at(static_cast<std::size_t>(p.geometry.kind));
  json["links"] = Json::array();
  for (const Recorded<RobotGeometry>& robot : setup.robots) {
    for (const LinkGeometry& link : robot.value.links) {
      Json described = {{"name", link.link},
                        {"triangles", link.mesh.triangleCount()},
                        {"source", link.source},
                        {"problem", link.problem}};
      // A link that changed while recording is listed with each of its meshes.
      if (!boost::algorithm::any_of_equal(json["links"], described))
        json["links"].push_back(std::move(described));
    }
  }
  json["margin_m"] = p.margin_m;
  json["link_margin_m"] = p.link_margin_m;
  json["objects"] = Json::array();
  for (const ObjectParameters& object : p.objects) {
    json["objects"].push_back(
        {{"name", object.name}, {"topic", topicOf(object)}, {"margin_m", object.margin_m}});
  }
  json["rigid_objects"] = Json::array();
  for (const RigidParameters& rigid : p.rigids) {
    json["rigid_objects"].push_back({{"name", rigid.name},
                                     {"frame", rigid.frame},
                                     {"triangles", rigid.mesh->triangleCount()},
                                     {"margin_m", rigid.margin_m}});
  }
  json["pair_classes"] = namesOf(p.pair_classes);
  json["allowed_contacts"] = Json::array();
  for (const AllowedContact& rule : p.allowed_contacts.rules()) {
    json["allowed_contacts"].push_back(
        {{"body_a", rule.body_a}, {"body_b", rule.body_b}, {"allowed", rule.allowed != 0}});
  }
  json["adjacent_pairs"] = toString(p.detector.adjacent);
  json["max_mesh_age_s"] = p.max_mesh_age_s;
  if (p.motion == Motion::kSwept) {
    json["motion"] = toString(p.motion);
    json["swept_tolerance_m"] = p.swept_tolerance_m;
  }
  return json;
}

bool isSwept(const EvaluationEnd& end) { return end.setup->parameters.motion == Motion::kSwept; }

// Describes the time intervals of swept motion.
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

// Lists the reasons of UNKNOWN, the most frequent first.
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

// Counts the frames that come from TF, and names those that come from joint states.
Json posesJson(const BagContents& contents) {
  Json by_joints = Json::array();
  const auto add = [&by_joints](const std::string& frame) {
    if (!boost::algorithm::any_of_equal(by_joints, frame)) by_joints.push_back(frame);
  };
  for (const auto& joints : contents.joint_transforms) {
    for (const JointTransforms::Moving& moving : joints.value->moving()) {
      const bool is_recorded =
          std::any_of(moving.sources.begin(), moving.sources.end(),
                      [&](const auto& source) { return contents.joints.count(source.joint) > 0; });
      if (is_recorded) add(moving.frame);
    }
    for (const auto& fixed : joints.value->fixed()) add(fixed.child_frame_id);
  }
  return {{"tf_frames", contents.parents.size() - by_joints.size()},
          {"joint_states_frames", by_joints}};
}

// Describes a run without its times.
Json runJson(const EvaluationRun& run) {
  return {{"name", run.name()},
          {"asked", run.asked},
          {"backend", run.detector->backend()},
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

// Summarises times; "most" is the largest.
Json percentiles(const std::vector<double>& ms) {
  return {{"median", median(ms)},
          {"p95", percentile(ms, 0.95)},
          {"p99", percentile(ms, 0.99)},
          {"most", percentile(ms, 1)}};
}

// Lists everything that differs from one evaluation to the next.
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

// Lists how each run differs from the first.
Json comparisonsJson(const EvaluationEnd& end) {
  Json json = Json::array();
  for (const RunComparison& comparison : *end.comparisons) {
    json.push_back({{"first", (*end.runs)[comparison.a]->name()},
                    {"second", (*end.runs)[comparison.b]->name()},
                    {"must_agree", comparison.must_agree},
                    {"cycles_that_differ", comparison.cycles},
                    {"only_first", comparison.found.only_a},
                    {"only_second", comparison.found.only_b},
                    {"example", comparison.found.example}});
  }
  return json;
}

// A run without a guarantee has no complete cycles by definition, so its whole cycles are counted
// instead: it must not look like a failure.
std::string cyclesText(const EvaluationRun& run) {
  const std::string of = " of " + std::to_string(run.cycles) + " cycles ";
  if (run.guaranteed == run.cycles) return std::to_string(run.complete) + of + "complete";
  return std::to_string(run.whole) + of + "with nothing left out, but without a guarantee";
}

// Returns the line of a run for people.
std::string runLine(const EvaluationRun& run) {
  const std::string times = formatted(", detect median %.3f ms, p95 %.3f ms\n",
                                      median(run.detect_ms), percentile(run.detect_ms, 0.95));
  return run.name() + " (on " + run.detector->backend() + "): " + std::to_string(run.pairs) +
         " pairs, " + cyclesText(run) + times;
}

// The number of reasons that standard output shows; summary.json has all.
constexpr std::size_t kShownReasons = 3;

// Returns a line for each of the most frequent reasons of UNKNOWN.
std::string unknownLines(const EvaluationRun& run) {
  std::string text;
  std::size_t count = 0;
  for (const UnknownReason& reason : run.unknown.all()) {
    if (++count > kShownReasons) continue;
    text += "UNKNOWN in " + std::to_string(reason.cycles) +
            (reason.cycles == 1 ? " cycle: " : " cycles: ") + oneLine(reason.text) + "\n";
  }
  if (count <= kShownReasons) return text;
  return text + "and " + counted(count - kShownReasons, "more reason", "more reasons") +
         " in summary.json\n";
}

// Returns the line about a run's time intervals.
std::string stepsLine(const EvaluationRun& run) {
  const RunSteps::Sums& sums = run.steps.sums();
  return formatted(
      "  between cycles: %ju pairs, %ju passed, %ju of %ju cycles with a step complete, "
      "pads up to %.3g m, median %.3f ms\n",
      sums.pairs, sums.passed, sums.complete, sums.cycles, sums.most_pad_m, median(sums.ms));
}

}  // namespace

bool isEvaluated(const EvaluationEnd& end) { return (*end.runs)[0]->unknown.evaluatedCycles() > 0; }

// Nothing evaluated is never a success, and neither is a part of a bag.
bool isPassed(const EvaluationEnd& end) {
  return isEvaluated(end) && end.damage.empty() &&
         std::none_of(end.comparisons->begin(), end.comparisons->end(), isDisagreement) &&
         std::all_of(end.expectations.begin(), end.expectations.end(),
                     [](const auto& verdict) { return verdict.failure.empty(); });
}

// Says more than passed or failed, because a pass with missing bodies proves little.
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

// The texts are ordered by what a user should mend first.
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

// The configuration's hash is a name-based UUID of its JSON text, so it is equal for equal
// settings.
std::string summaryJson(const EvaluationEnd& end) {
  Json json;
  json["version"] = DCM_VERSION;
  json["bags"] = end.arguments->files.bags;
  json["topics"] = topicsJson(*end.contents);
  json["problem"] = end.problem;
  json["damaged_messages"] = end.contents->damaged();
  json["refused_transforms"] = end.refused_transforms;
  json["cycles_with_late_transforms"] = end.late_cycles;
  json["meshes_with_triangles_sent_later"] = end.contents->triangles_ahead.count();
  json["poses"] = posesJson(*end.contents);
  json["configuration"] = configurationJson(*end.setup);
  // The hash tells evaluations with different settings apart.
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
  json["unjudged_cycles"] = end.runs->empty() ? 0 : (*end.runs)[0]->judge.unjudgedCycles();
  json["passed"] = isPassed(end);
  json["verdict"] = verdictText(end);
  json["machine"] = machineJson();
  json["times"] = timesJson(end);
  return jsonText(json);
}

// The verdict comes last, because people read the last lines first.
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
              std::to_string(comparison.cycles) + " cycles; " + comparison.found.example + "\n";
    }
  }
  for (const auto& verdict : end.expectations) {
    text += (verdict.failure.empty() ? "holds: " : "FAILS: ") + verdict.text +
            (verdict.failure.empty() ? "" : " (" + verdict.failure + ")") + "\n";
  }
  if (!end.runs->empty()) {
    const std::uint64_t unjudged = (*end.runs)[0]->judge.unjudgedCycles();
    if (unjudged > 0) {
      text += counted(unjudged, "cycle was", "cycles were") +
              " not judged where UNKNOWN: the transforms of the bag begin later or end earlier\n";
    }
    text += unknownLines(*(*end.runs)[0]);
  }
  const std::size_t by_joints = posesJson(*end.contents)["joint_states_frames"].size();
  if (by_joints > 0) {
    text += std::to_string(by_joints) + " frames that TF does not have stand where " +
            end.contents->chosen.joint_states + " and the URDF say\n";
  }
  return text + verdictText(end) + "\n" + formatted("%.1f s; written to ", end.elapsed_s) +
         end.arguments->out + "\n";
}

}  // namespace deformable_contact_monitor
