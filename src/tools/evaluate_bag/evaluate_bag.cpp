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
#include <utility>
#include <vector>

#include "core/common/stopwatch.h"
#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_setup.h"
#include "tools/bags/stamp_text.h"
#include "tools/common/output_file.h"
#include "tools/common/progress.h"
#include "tools/common/run_tool.h"
#include "tools/common/script.h"
#include "tools/evaluate_bag/evaluate_arguments.h"
#include "tools/evaluate_bag/evaluation_run.h"
#include "tools/evaluate_bag/evaluation_runs.h"
#include "tools/evaluate_bag/evaluation_summary.h"
#include "tools/evaluate_bag/evaluation_tables.h"
#include "tools/evaluate_bag/evaluation_verdict.h"
#include "tools/evaluate_bag/recorded_contacts.h"
#include "tools/evaluate_bag/swept_tables.h"

namespace deformable_contact_monitor {
namespace {

using Runs = std::vector<std::unique_ptr<EvaluationRun>>;
using Sources = std::vector<std::unique_ptr<ContactSource>>;

void warn(const std::string& what) {
  std::fprintf(stderr, "evaluate_bag: warning: %s\n", oneLine(what).c_str());
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
  for (auto& run : *runs) run->evaluate(cycle, scene);
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

// Writes what came of an evaluation, but for the tables. Returns the exit code.
int report(const EvaluationEnd& end) {
  const EvaluateArguments& arguments = *end.arguments;
  OutputFile(arguments.out + "/summary.json").write(summaryJson(end));
  if (arguments.report) runScriptBeside("evaluation_report.py", {arguments.out}, warn);
  OutputFile("-").write(summaryText(end));
  const std::string damaged = end.problem.empty() ? damage(*end.contents) : end.problem;
  if (!damaged.empty()) {
    throw std::runtime_error("damaged: " + damaged + "; what could be read is in " + arguments.out);
  }
  if (!isEvaluated(end)) {
    throw std::runtime_error("no cycle could be evaluated: " + whyNothing(end) +
                             "; what could be read is in " + arguments.out);
  }
  return isPassed(end) ? 0 : 1;
}

// The bags, looked through once.
struct Scanned {
  explicit Scanned(const EvaluateArguments& arguments)
      : configured(readBagParameters(arguments.files, warn)),
        reader(arguments.files.bags, neededMessages(configured)) {  // forks: before threads
    ros::Time::init();
    console_bridge::noOutputHandler();  // tf2 would print a line for each bad transform
    if (!arguments.expectations.empty()) expectations = readExpectations(arguments.expectations);
    progress.emplace("reading the bags");
    contents = scanBags(&reader, [this](std::uint64_t count) {
      if (count % 1000 == 0) progress->set("reading the bags, message " + std::to_string(count));
    });
    setup = setUp(arguments, configured, &contents);
    checkBodies(bodyNames(setup), setup.robot.link_names, &expectations);
    for (const Expectation& expectation : expectations) {
      if (!expectation.problem.empty()) warn(arguments.expectations + ": " + expectation.problem);
    }
    settings = runSettings(arguments, setup.parameters);
  }

  BagCycles cycles() const {
    return BagCycles(setup.parameters, contents, setup.robot,
                     setup.played ? &*setup.played : nullptr);
  }
  void show(const CycleReport& cycle) {
    progress->set("cycle " + std::to_string(cycle.cycle) + ", stamp " +
                  stampText(cycle.header.stamp));
  }

  const MonitorParameters configured;
  BagReader reader;
  std::vector<Expectation> expectations;
  std::optional<Progress> progress;
  BagContents contents;
  BagSetup setup;
  std::vector<RunSettings> settings;
};

int writeRecords(const EvaluateArguments& arguments) {
  const Stopwatch stopwatch;
  Scanned bags(arguments);
  const Runs runs =
      makeRuns(bags.settings, makeDetected(bags.settings, bags.setup.parameters, warn),
               bags.setup.parameters, bags.expectations);
  std::vector<std::string> backends;
  for (const auto& run : runs) {
    backends.push_back(run->source->backend());
    if (isExact(*run)) continue;
    throw std::invalid_argument("--part: what " + run->name() +
                                " finds depends on the cycles before; there are parts of exact "
                                "predicates on cpu and cuda with overlap 1 alone");
  }
  RecordsWriter writer(arguments.records, *arguments.part,
                       originOf(arguments.files.bags, bags.contents, bags.setup, bags.settings),
                       backends);
  BagCycles cycles = bags.cycles();
  cycles.runPart(*arguments.part, &bags.reader, [&](CycleReport* cycle) {
    bags.show(*cycle);
    writer.add(recordOf(runs, &cycles.sceneOfStep(), cycle));
  });
  writer.finish(stopwatch.elapsedMs() / 1e3);
  bags.progress.reset();
  OutputFile("-").write(std::to_string(writer.cycles()) + " cycles; written to " +
                        arguments.records + "\n");
  return 0;
}

int evaluate(const EvaluateArguments& arguments) {
  const Stopwatch stopwatch;
  Scanned bags(arguments);
  std::shared_ptr<RecordedCycles> recorded;
  Sources sources;
  if (arguments.joined.empty()) {
    sources = makeDetected(bags.settings, bags.setup.parameters, warn);
  } else {
    recorded = std::make_shared<RecordedCycles>(
        RecordsReader(arguments.joined,
                      originOf(arguments.files.bags, bags.contents, bags.setup, bags.settings)));
    for (std::size_t i = 0; i < bags.settings.size(); ++i) {
      sources.push_back(std::make_unique<RecordedContacts>(recorded, i));
    }
  }
  Runs runs = makeRuns(bags.settings, std::move(sources), bags.setup.parameters, bags.expectations);
  std::vector<RunComparison> compared = comparisons(runs);
  Tables tables(cleanFolder(arguments.out), arguments.pairs,
                bags.setup.parameters.motion == Motion::kSwept);
  BagCycles cycles = bags.cycles();

  EvaluationEnd end;
  end.problem = cycles.run(&bags.reader, [&](CycleReport* cycle) {
    bags.show(*cycle);
    evaluateCycle(cycle, &cycles.sceneOfStep(), &runs, &compared, &tables);
  });
  if (recorded) recorded->requireEnd();
  tables.finish();
  bags.progress.reset();
  // The two readings of a damaged bag need not end alike.
  if (end.problem.empty()) end.problem = bags.contents.problem;

  end.arguments = &arguments;
  end.contents = &bags.contents;
  end.setup = &bags.setup;
  end.runs = &runs;
  end.comparisons = &compared;
  end.expectations = runs[0]->judge.verdicts();
  end.refused_transforms = cycles.refusedTransforms();
  end.elapsed_s = stopwatch.elapsedMs() / 1e3 + (recorded ? recorded->elapsedS() : 0);
  return report(end);
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  std::signal(SIGPIPE, SIG_IGN);
  return dcm::runTool("evaluate_bag", [argc, argv] {
    dcm::EvaluateArguments arguments;
    if (!dcm::parseArguments(argc, argv, &arguments)) return 0;
    return arguments.part ? dcm::writeRecords(arguments) : dcm::evaluate(arguments);
  });
}
