// evaluate_bag: finds the contacts of every deformable mesh in ROS bags, without a ROS master.
//
// The bags are read twice: once to learn what they hold (topics, frames, triangles that come late),
// and once to run a cycle for each mesh. All runs see a cycle before the next one is made, so
// memory holds some seconds of the bags. Tables are written row by row on the way; the summary
// follows at the end. README.md says how results may differ from those of the live node.
#include <console_bridge/console.h>
#include <ros/time.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/common/stopwatch.h"
#include "core/steady_time.h"
#include "monitor/cycle/rigid_place.h"
#include "monitor/diagnostics/body_checks.h"
#include "monitor/time_difference.h"
#include "robot/urdf_document.h"
#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_setup.h"
#include "tools/common/formatted.h"
#include "tools/common/output_file.h"
#include "tools/common/progress.h"
#include "tools/common/reports.h"
#include "tools/common/run_tool.h"
#include "tools/evaluate_bag/evaluate_arguments.h"
#include "tools/evaluate_bag/evaluation_run.h"
#include "tools/evaluate_bag/evaluation_summary.h"
#include "tools/evaluate_bag/evaluation_tables.h"

namespace deformable_contact_monitor {
namespace {

using Runs = std::vector<std::unique_ptr<EvaluationRun>>;

// Writes a warning as one line.
void warn(const std::string& what) {
  std::fprintf(stderr, "evaluate_bag: warning: %s\n", oneLine(what).c_str());
}

// Prints what the node would log about the bodies of its cycles, once for each body.
class BodyWarnings {
 public:
  // The cycle must have been evaluated. Recorded time decides when a size is checked again.
  void look(const CycleReport& cycle) {
    const SteadyTime now{std::chrono::nanoseconds(cycle.header.stamp.toNSec())};
    for (const auto& [object, anomaly] : size_check_.look(cycle, now)) {
      if (anomaly.empty() || !warned_.insert(object).second) continue;
      warn("object '" + object + "': " + anomaly);
    }
    if (cycle.containment == nullptr) return;
    for (const std::string& line : open_bodies_.look(cycle)) warn(line);
  }

 private:
  SizeCheck size_check_;
  OpenBodies open_bodies_;
  std::set<std::string> warned_;
};

// Runs all backends on a cycle, compares them, and writes the rows of the tables.
void evaluateCycle(CycleReport* cycle, Scene* scene, bool at_edge, Runs* runs,
                   std::vector<RunComparison>* compared, EvaluationTables* tables) {
  for (auto& run : *runs) run->evaluate(cycle, scene, at_edge);
  // Each comparison is with the first run, so one flag a run is enough.
  std::vector<bool> differing(runs->size(), false);
  for (RunComparison& comparison : *compared) {
    const EvaluationRun &a = *(*runs)[comparison.a], &b = *(*runs)[comparison.b];
    SetDifference found = difference(*scene, *a.result, *b.result);
    found.add(difference(*scene, a.steps, b.steps));
    if (found.isEmpty()) continue;
    differing[comparison.b] = true;
    ++comparison.cycles;
    found.example = "at " + stampText(cycle->header.stamp) + " " + found.example;
    comparison.found.add(found);
  }
  tables->add(*cycle, *runs, differing);
}

// Says why the bags were not read completely. Empty: they were.
std::string damage(const BagContents& contents) {
  if (!contents.problem.empty()) return contents.problem;
  for (const auto& [name, topic] : contents.topics) {
    if (topic.damaged == 0) continue;
    return std::to_string(contents.damaged()) + " messages, on " + name +
           " for example: " + topic.damage;
  }
  return "";
}

// Applies the options that setUpBags() does not know. If the bag is damaged, the error says so
// first, because what is missing may have been in the part that could not be read.
BagSetup setUp(const EvaluateArguments& arguments, const MonitorParameters& configured,
               BagContents* contents) {
  MonitorParameters parameters = configured;
  const auto* const kind =
      std::find(kGeometryKinds.begin(), kGeometryKinds.end(), arguments.geometry);
  if (kind != kGeometryKinds.end()) {
    parameters.geometry.kind = static_cast<GeometryKind>(kind - kGeometryKinds.begin());
  }
  try {
    return setUpBags(arguments.files, parameters, arguments.object, contents, warn);
  } catch (const std::exception& error) {
    const std::string damaged = damage(*contents);
    if (damaged.empty()) throw;
    throw std::runtime_error("damaged: " + damaged + "; " + error.what());
  }
}

// Returns the margin of an object, a part of one or a link [m]. For an object this is the least
// margin of its parts, because its NONE is certain only up to that.
BodyMargin marginOf(const MonitorParameters& parameters, const std::string& body) {
  for (const ObjectParameters& object : parameters.objects) {
    if (!hasName(bodyOf(object), body)) continue;
    float margin_m = object.margin_m;
    for (const PartParameters& part : object.parts) {
      if (body == object.name + ":" + part.name) {
        return {object.name, part.margin_m.value_or(object.margin_m)};
      }
      margin_m = std::min(margin_m, part.margin_m.value_or(margin_m));
    }
    return {object.name, margin_m};
  }
  const RigidParameters* const rigid = findRigid(parameters, body);
  return {body, rigid != nullptr ? rigid->margin_m : linkMarginM(parameters, body)};
}

// Marks the expectations that name something else than an object or a link with geometry of any
// robot in the bags, and those that no distance within the margins can show.
void checkExpectations(const BagSetup& setup, std::vector<Expectation>* expectations) {
  std::vector<std::string> bodies;
  std::set<std::string> links;
  for (const Recorded<RobotGeometry>& robot : setup.robots) {
    for (const LinkGeometry& link : robot.value.links) bodies.push_back(link.link);
    links.insert(robot.value.link_names.begin(), robot.value.link_names.end());
  }
  for (const RigidParameters& rigid : setup.parameters.rigids) bodies.push_back(rigid.name);
  for (const ObjectParameters& object : setup.parameters.objects) {
    const BodyStatus body = bodyOf(object);
    for (std::size_t part = 0; part <= body.partCount(); ++part) {
      bodies.push_back(nameOf(body, static_cast<PartId>(part)));
    }
  }
  checkBodies(bodies, links, expectations);
  checkMargins([&setup](const std::string& body) { return marginOf(setup.parameters, body); },
               setup.parameters.detector.near_pairs && hasMargins(setup.parameters), expectations);
}

// Makes the folder, and removes files of an earlier evaluation that this one may not write.
std::string cleanFolder(const std::string& folder) {
  makeFolder(folder);
  for (const char* name : {"/frames.csv", "/links.csv", "/events.csv", "/distances.csv",
                           "/summary.json", "/pairs.csv", "/swept_pairs.csv", "/report.html"}) {
    std::error_code none;
    std::filesystem::remove(folder + name, none);
  }
  return folder;
}

// Writes summary, report and standard output. Returns the exit code.
int report(const EvaluationEnd& end) {
  const EvaluateArguments& arguments = *end.arguments;
  OutputFile(arguments.out + "/summary.json").write(summaryJson(end));
  // The report is drawn from the files, so they must be complete.
  if (arguments.report) runPlotScript("evaluation_report.py", {arguments.out}, warn);
  OutputFile("-").write(summaryText(end));
  if (!end.damage.empty()) {
    throw std::runtime_error("damaged: " + end.damage + "; what could be read is in " +
                             arguments.out);
  }
  if (!isEvaluated(end)) {
    throw std::runtime_error("no cycle could be evaluated: " + whyNothing(end) +
                             "; what could be read is in " + arguments.out);
  }
  return isPassed(end) ? 0 : 1;
}

// The configuration, and what the first reading of the bags found.
struct Scanned {
  explicit Scanned(const EvaluateArguments& arguments)
      : configured(readBagParameters(arguments.files, warn)),
        // The reader forks, so it must be made before any thread starts.
        reader(arguments.files.bags, neededMessages(configured, arguments.files)) {
    ros::Time::init();
    console_bridge::noOutputHandler();  // tf2 would print a line for each bad transform
    if (!arguments.expectations.empty()) expectations = readExpectations(arguments.expectations);
    progress.emplace("reading the bags");
    contents = scanBags(&reader, arguments.files, configured, [this](std::uint64_t count) {
      if (count % 1000 == 0) progress->set("reading the bags, message " + std::to_string(count));
    });
    setup = setUp(arguments, configured, &contents);
    checkExpectations(setup, &expectations);
    for (const Expectation& expectation : expectations) {
      if (!expectation.problem.empty()) warn(arguments.expectations + ": " + expectation.problem);
    }
    settings = runSettings(arguments, setup.parameters);
  }

  const MonitorParameters configured;
  BagReader reader;
  std::vector<Expectation> expectations;
  std::optional<Progress> progress;
  BagContents contents;
  BagSetup setup;
  std::vector<RunSettings> settings;
};

// Says what a user should know of the transforms that were used and that were not.
void warnOfTransforms(const BagCycles& cycles, double tf_timeout_s) {
  if (cycles.badTransforms() > 0) {
    warn(std::to_string(cycles.badTransforms()) +
         " transforms are left out: their frames have no names, their numbers are not finite, "
         "their quaternions are of length 0, or their stamps are far ahead of their recording");
  }
  if (cycles.lateCycles() > 0) {
    warn("cycles with transforms that were recorded more than tf_timeout_s (" +
         formatted("%g", tf_timeout_s) +
         " s) after their mesh: " + std::to_string(cycles.lateCycles()) +
         "; the node would not have waited for them, and said UNKNOWN");
  }
}

// Says what the live node would have made of meshes that came late, and what is not evaluated.
void warnOfLiveNode(const BagContents& contents, const MonitorParameters& parameters) {
  constexpr double kOtherClockS = 60;  // nothing takes so long to arrive
  std::size_t late = 0;
  double latest_s = 0;
  const bool is_one_clock = contents.jumps.all().empty();
  for (const BagContents::Mesh& mesh : contents.meshes) {
    if (!is_one_clock) break;
    const double age_s = secondsBetween(mesh.received, mesh.stamp);
    if (age_s <= parameters.max_mesh_age_s || age_s > kOtherClockS) continue;
    ++late;
    latest_s = std::max(latest_s, age_s);
  }
  if (late > 0) {
    warn("meshes that were recorded more than max_mesh_age_s (" +
         formatted("%g", parameters.max_mesh_age_s) +
         " s) after their stamps: " + std::to_string(late) + ", by " + formatted("%.3f", latest_s) +
         " s at most; the live node would have rejected them, and reported UNKNOWN");
  }
  if (parameters.pair_classes.needRobotCycles()) {
    warn("pairs of links, and of links with rigid objects, are not evaluated: they stay UNKNOWN");
  }
}

// Says that the simulated object did not always move as the links pushed it.
void warnOfUndoneSteps(const BagCycles::UndoneSteps& undone, const std::string& object) {
  if (undone.count == 0) return;
  warn("object '" + object + "': the simulation undid a step in " + std::to_string(undone.count) +
       " of its states, and the object stayed where it was; the first time: " + undone.first);
}

// Evaluates the bags. Returns the exit code.
int evaluate(const EvaluateArguments& arguments) {
  const Stopwatch stopwatch;
  Scanned bags(arguments);
  Runs runs = makeRuns(bags.settings, bags.setup.parameters, bags.expectations, warn);
  std::vector<RunComparison> compared = comparisons(runs);
  EvaluationTables tables(cleanFolder(arguments.out), arguments.pairs,
                          bags.setup.parameters.motion == Motion::kSwept,
                          bags.setup.parameters.max_mesh_age_s);
  BagCycles cycles(bags.setup.parameters, bags.contents, bags.setup.robots,
                   bags.setup.played ? &*bags.setup.played : nullptr);

  BodyWarnings warnings;
  EvaluationEnd end;
  end.problem = cycles.run(&bags.reader, [&](CycleReport* cycle) {
    bags.progress->set("cycle " + std::to_string(cycle->cycle) + ", stamp " +
                       stampText(cycle->header.stamp));
    if (!cycles.forgets().empty()) {
      for (auto& run : runs) run->forget(cycles.forgets(), cycle->header.stamp);
    }
    evaluateCycle(cycle, &cycles.sceneOfStep(), bags.contents.isAtEdge(cycle->header.stamp), &runs,
                  &compared, &tables);
    warnings.look(*cycle);
  });
  tables.finish();
  bags.progress.reset();
  warnOfTransforms(cycles, bags.setup.parameters.tf_timeout_s);
  warnOfLiveNode(bags.contents, bags.setup.parameters);
  warnOfUndoneSteps(cycles.undoneSteps(), arguments.object.name);
  // A damaged bag is read twice, and the two readings may end differently.
  if (end.problem.empty()) end.problem = bags.contents.problem;
  end.damage = end.problem.empty() ? damage(bags.contents) : end.problem;

  end.arguments = &arguments;
  end.contents = &bags.contents;
  end.setup = &bags.setup;
  end.runs = &runs;
  end.comparisons = &compared;
  // The end is not known if the clock went back, and a played object may end before the bag.
  const bool has_end = bags.contents.jumps.all().empty() && !bags.setup.played;
  end.expectations = runs[0]->judge.verdicts(has_end ? bags.contents.ended() : ros::Time());
  end.refused_transforms = cycles.refusedTransforms();
  end.late_cycles = cycles.lateCycles();
  end.elapsed_s = stopwatch.elapsedMs() / 1e3;
  return report(end);
}

}  // namespace
}  // namespace deformable_contact_monitor

// Exit code: 0: passed; 1: failed; 2: bad input, a damaged bag, or nothing could be evaluated.
int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  std::signal(SIGPIPE, SIG_IGN);
  return dcm::runTool("evaluate_bag", [argc, argv] {
    dcm::EvaluateArguments arguments;
    if (!dcm::parseArguments(argc, argv, &arguments)) return 0;
    return dcm::evaluate(arguments);
  });
}
