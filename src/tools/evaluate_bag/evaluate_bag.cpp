// evaluate_bag: the contacts of every deformable mesh in ROS bags. Needs no ROS master.
#include <console_bridge/console.h>
#include <ros/time.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/stopwatch.h"
#include "cuda/device/cuda_error.h"
#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_setup.h"
#include "tools/bags/stamp_text.h"
#include "tools/common/backend_choice.h"
#include "tools/common/output_file.h"
#include "tools/common/progress.h"
#include "tools/common/run_tool.h"
#include "tools/common/script.h"
#include "tools/evaluate_bag/evaluate_arguments.h"
#include "tools/evaluate_bag/evaluation_run.h"
#include "tools/evaluate_bag/evaluation_summary.h"
#include "tools/evaluate_bag/evaluation_tables.h"
#include "tools/evaluate_bag/evaluation_verdict.h"
#include "tools/evaluate_bag/swept_tables.h"

namespace deformable_contact_monitor {
namespace {

using Runs = std::vector<std::unique_ptr<EvaluationRun>>;

void warn(const std::string& what) {
  std::fprintf(stderr, "evaluate_bag: warning: %s\n", oneLine(what).c_str());
}

// Unlike the node: what is called cuda ran with CUDA.
std::unique_ptr<Detector> makeBackend(const std::string& backend, const CudaSettings& settings) {
  try {
    return makeDetector(backend, WithoutCuda::kRefuse, settings, warn);
  } catch (const CudaError& error) {
    throw std::runtime_error(std::string(error.what()) + "; --backends cpu needs no GPU");
  }
}

bool hasMargins(const MonitorParameters& parameters) {
  bool any = parameters.margin_m > 0;
  for (const ObjectParameters& object : parameters.objects) any |= object.margin_m > 0;
  for (const auto& [link, margin_m] : parameters.link_margin_m) any |= margin_m > 0;
  return any;
}

Runs makeRuns(const EvaluateArguments& arguments, const MonitorParameters& parameters,
              const std::vector<Expectation>& expectations) {
  std::vector<std::string> backends = arguments.backends;
  if (backends.empty()) backends = {toString(parameters.backend)};
  std::vector<Predicates> predicates;
  for (const std::string& name : arguments.predicates) predicates.push_back(toPredicates(name));
  if (predicates.empty()) predicates = {parameters.detector.predicates};
  std::vector<float> overlaps = arguments.overlaps;
  if (overlaps.empty()) overlaps = {parameters.detector.overlap};
  StateRules rules;
  rules.max_age_s = parameters.max_mesh_age_s;
  rules.tolerated_rejects = parameters.tolerated_rejects;
  rules.since_survives_s = parameters.since_survives_s;
  rules.debounce_on_cycles = parameters.debounce_on_cycles;
  rules.debounce_off_cycles = parameters.debounce_off_cycles;
  Runs runs;
  for (const Predicates p : predicates) {
    for (const float overlap : overlaps) {
      for (const std::string& backend : backends) {
        Options options = parameters.detector;
        options.predicates = p;
        options.overlap = overlap;
        runs.push_back(
            std::make_unique<EvaluationRun>(backend, makeBackend(backend, parameters.cuda), options,
                                            rules, expectations, parameters.containment));
        if (hasMargins(parameters) && !supportsMargins(*runs.back()->detector)) {
          throw std::invalid_argument("backend " + backend + " has no margins; set margin_m to 0");
        }
        if (parameters.motion == Motion::kSwept && backend == "fcl") {
          throw std::invalid_argument("backend fcl knows no swept motion; set motion to instant");
        }
        runs.back()->swept_tolerance_m = parameters.swept_tolerance_m;
      }
    }
  }
  return runs;
}

// Everything that is written while the evaluation goes.
struct Tables {
  Tables(const std::string& folder, bool with_pairs, bool swept)
      : frames(folder), links(folder), events(folder) {
    if (with_pairs) pairs.emplace(folder);
    if (with_pairs && swept) swept_pairs.emplace(folder);
  }

  void finish() {
    frames.finish();
    links.finish();
    events.finish();
    if (pairs) pairs->finish();
    if (swept_pairs) swept_pairs->finish();
  }

  FramesTable frames;
  LinksTable links;
  EventsTable events;
  std::optional<PairsTable> pairs;
  std::optional<SweptPairsTable> swept_pairs;
};

void evaluateCycle(CycleReport* cycle, Scene* scene, Runs* runs,
                   std::vector<RunComparison>* compared, Tables* tables) {
  for (auto& run : *runs) run->detect(cycle, scene);
  std::vector<bool> differing(runs->size(), false);
  for (RunComparison& comparison : *compared) {
    const EvaluationRun &a = *(*runs)[comparison.a], &b = *(*runs)[comparison.b];
    SetDifference found = difference(*scene, *a.result, *b.result);
    found.add(difference(*scene, a.steps, b.steps));
    if (found.isEmpty()) continue;
    differing[comparison.b] = true;
    ++comparison.cycles;
    comparison.only_a += found.only_a;
    comparison.only_b += found.only_b;
    if (comparison.example.empty()) {
      comparison.example = "at " + stampText(cycle->header.stamp) + " " + found.example;
    }
  }
  tables->frames.add(*cycle, *runs, differing);
  for (std::size_t i = 0; i < runs->size(); ++i) {
    tables->links.add(i, *(*runs)[i]);
    tables->events.add(*cycle, *(*runs)[i]);
  }
  if (tables->pairs) tables->pairs->add(*cycle, *(*runs)[0]->result);
  if (tables->swept_pairs) tables->swept_pairs->add(*cycle, (*runs)[0]->steps);
}

// Why the bags were not read to their end, or whole; empty: they were.
std::string damage(const BagContents& contents) {
  if (!contents.problem.empty()) return contents.problem;
  return contents.damaged() > 0 ? std::to_string(contents.damaged()) + " messages" : "";
}

// What is missing may have been in what could not be read.
BagSetup setUp(const EvaluateArguments& arguments, const MonitorParameters& configured,
               BagContents* contents) {
  try {
    return setUpBags(arguments.files, configured, arguments.object, contents, warn);
  } catch (const std::exception& error) {
    const std::string damaged = damage(*contents);
    if (damaged.empty()) throw;
    throw std::runtime_error("damaged: " + damaged + "; " + error.what());
  }
}

std::vector<std::string> bodyNames(const BagSetup& setup) {
  std::vector<std::string> names;
  for (const LinkGeometry& link : setup.robot.links) names.push_back(link.link);
  for (const ObjectParameters& object : setup.parameters.objects) names.push_back(object.name);
  return names;
}

// Made if need be. What this evaluation may not write must not be an earlier one's.
std::string cleanFolder(const std::string& folder) {
  makeFolder(folder);
  for (const char* name : {"/frames.csv", "/links.csv", "/events.csv", "/summary.json",
                           "/pairs.csv", "/swept_pairs.csv", "/report.html"}) {
    std::error_code none;
    std::filesystem::remove(folder + name, none);
  }
  return folder;
}

int evaluate(const EvaluateArguments& arguments) {
  const Stopwatch stopwatch;
  const MonitorParameters configured = readBagParameters(arguments.files, warn);
  // Before threads, because it forks.
  BagReader reader(arguments.files.bags, neededMessages(configured));
  ros::Time::init();
  console_bridge::noOutputHandler();  // tf2 would print a line for each bad transform
  std::vector<Expectation> expectations;
  if (!arguments.expectations.empty()) expectations = readExpectations(arguments.expectations);

  std::optional<Progress> progress("reading the bags");
  BagContents contents = scanBags(&reader, [&](std::uint64_t count) {
    if (count % 1000 == 0) progress->set("reading the bags, message " + std::to_string(count));
  });
  const BagSetup setup = setUp(arguments, configured, &contents);
  checkBodies(bodyNames(setup), setup.robot.link_names, &expectations);
  for (const Expectation& expectation : expectations) {
    if (!expectation.problem.empty()) warn(arguments.expectations + ": " + expectation.problem);
  }
  Runs runs = makeRuns(arguments, setup.parameters, expectations);
  std::vector<RunComparison> compared = comparisons(runs);
  Tables tables(cleanFolder(arguments.out), arguments.pairs,
                setup.parameters.motion == Motion::kSwept);
  BagCycles cycles(setup.parameters, contents, setup.robot,
                   setup.played ? &*setup.played : nullptr);

  EvaluationEnd end;
  end.problem = cycles.run(&reader, [&](CycleReport* cycle) {
    progress->set("cycle " + std::to_string(cycle->cycle) + ", stamp " +
                  stampText(cycle->header.stamp));
    evaluateCycle(cycle, &cycles.sceneOfStep(), &runs, &compared, &tables);
  });
  tables.finish();
  progress.reset();
  // The two readings of a damaged bag need not end alike.
  if (end.problem.empty()) end.problem = contents.problem;

  end.arguments = &arguments;
  end.contents = &contents;
  end.setup = &setup;
  end.runs = &runs;
  end.comparisons = &compared;
  end.expectations = runs[0]->judge.verdicts();
  end.refused_transforms = cycles.refusedTransforms();
  end.elapsed_s = stopwatch.elapsedMs() / 1e3;
  OutputFile(arguments.out + "/summary.json").write(summaryJson(end));
  if (arguments.report) runScriptBeside("evaluation_report.py", {arguments.out}, warn);
  OutputFile("-").write(summaryText(end));
  const std::string damaged = end.problem.empty() ? damage(contents) : end.problem;
  if (!damaged.empty()) {
    throw std::runtime_error("damaged: " + damaged + "; what could be read is in " + arguments.out);
  }
  if (!isEvaluated(end)) {
    throw std::runtime_error("no cycle could be evaluated: " + whyNothing(end) +
                             "; what could be read is in " + arguments.out);
  }
  return isPassed(end) ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  std::signal(SIGPIPE, SIG_IGN);
  return dcm::runTool("evaluate_bag", [argc, argv] {
    dcm::EvaluateArguments arguments;
    return dcm::parseArguments(argc, argv, &arguments) ? dcm::evaluate(arguments) : 0;
  });
}
