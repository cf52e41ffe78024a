// measure_trade: measures the speed-accuracy trade-off of the detector's settings on a scene.
//
// There are five measurements, one for each run function: the grid of settings (run), what instant
// motion loses (runSwept), tolerances with time budgets (runBounds), margins (runMargins), and
// states of a robot (runStates). Each opens its output files before it measures, so that nothing is
// lost at its end, and then writes the tables, draws plots and prints the choice.
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tools/common/backend_choice.h"
#include "tools/common/output_file.h"
#include "tools/common/progress.h"
#include "tools/common/reports.h"
#include "tools/common/run_tool.h"
#include "tools/measure_trade/bound_measurement.h"
#include "tools/measure_trade/bound_report.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/margin_measurement.h"
#include "tools/measure_trade/motion_measurement.h"
#include "tools/measure_trade/motion_report.h"
#include "tools/measure_trade/state_measurement.h"
#include "tools/measure_trade/trade_arguments.h"
#include "tools/measure_trade/trade_measurement.h"
#include "tools/measure_trade/trade_report.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kNoContact = "no frame has a contact, so recall says nothing";

// Writes a note as one line.
void note(const std::string& what) {
  std::fprintf(stderr, "measure_trade: note: %s\n", oneLine(what).c_str());
}

// Opens the bags or the mesh files of the command line.
std::unique_ptr<FrameSource> openFrames(const TradeArguments& arguments,
                                        const SayProgress& progress) {
  // Between frames that are left out, objects move farther than in one step.
  const auto most_frames = static_cast<std::size_t>(arguments.swept ? 0 : arguments.most_frames);
  if (!arguments.recorded.bags.empty()) {
    return makeBagFrames(arguments.recorded, most_frames, progress, note);
  }
  return makeMeshFrames(arguments.meshes, progress);
}

// Makes a detector. "cuda" never falls back to the CPU, because the figures would be wrong.
std::unique_ptr<Detector> makeBackend(const std::string& backend,
                                      const std::shared_ptr<TilingCache>& tilings = nullptr) {
  return makeDetector(backend, WithoutCuda::kRefuse, CudaSettings(), note, tilings);
}

// Opens the frames, makes the output folder, and measures while progress is shown.
void withFrames(const TradeArguments& arguments,
                const std::function<void(FrameSource*, Progress*)>& measure) {
  // Progress has a thread, which must not exist before the reader of bags has forked.
  std::optional<Progress> progress;
  const SayProgress say = [&progress](const std::string& what) {
    if (!progress) progress.emplace(what);
    progress->set(what);
  };
  const std::unique_ptr<FrameSource> frames = openFrames(arguments, say);
  say("starting");
  makeFolder(arguments.out_folder);
  measure(frames.get(), &*progress);
}

// Opens a file of the output folder.
OutputFile outputOf(const TradeArguments& arguments, const char* name) {
  return OutputFile(arguments.out_folder + "/" + name);
}

// Opens the file of --write-config, if there is one.
std::optional<OutputFile> configOf(const TradeArguments& arguments) {
  if (arguments.config_file.empty()) return std::nullopt;
  return std::optional<OutputFile>(std::in_place, arguments.config_file);
}

void drawPlots(const TradeArguments& arguments, const char* script, Progress* progress) {
  progress->set("drawing");
  runPlotScript(script, {"--out", arguments.out_folder, arguments.out_folder}, note);
}

// Reports measurements that show a defect. Returns the exit code.
template <class Measurements>
int exitCode(const Measurements& all, const char* what) {
  int code = 0;
  for (const auto& m : all) {
    if (m.broken.empty()) continue;
    std::fprintf(stderr, "measure_trade: BROKEN %s, please report it: %s\n", what,
                 m.broken.c_str());
    code = 1;
  }
  return code;
}

// Calls measure(m, cycles) for a measurement m of each setting, and returns them.
template <class Measurement, class Settings, class Measure>
std::vector<Measurement> measureEach(const TradeArguments& arguments, const Settings& settings,
                                     std::size_t frame_count, Progress* progress,
                                     const Measure& measure) {
  const int frames = static_cast<int>(frame_count);
  const CycleCounts cycles{arguments.warm_up, (arguments.least_cycles - 1) / frames + 1};
  std::vector<Measurement> all(settings.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].setting = settings[i];
    progress->setDone(static_cast<double>(i) / static_cast<double>(all.size()));
    progress->set("setting " + std::to_string(i + 1) + " of " + std::to_string(all.size()) + ": " +
                  describe(settings[i]));
    measure(&all[i], cycles);
  }
  progress->setDone(1);
  return all;
}

// Runs every setting of the grid, and chooses one.
TradeResults measureAll(const TradeArguments& arguments, FrameSource* frames, Progress* progress) {
  const std::vector<Setting> settings = settingsOf(arguments.grid, arguments.base);
  for (const std::string& backend : arguments.grid.backends)
    makeBackend(backend);  // fails now if it is missing
  TradeResults results;
  results.exact = exactResults(frames, arguments.base.adjacent,
                               [&](const std::string& what) { progress->set(what); });
  // Cycles are rounded up to whole passes, so that every frame counts equally.
  const int frame_count = static_cast<int>(results.exact.labels.size());
  const int cycles_each = (arguments.least_cycles - 1) / arguments.repeats + 1;
  const CycleCounts cycles{arguments.warm_up, (cycles_each - 1) / frame_count + 1};
  results.measurements.resize(settings.size());
  // Each repeat runs all settings, so that a slow phase of the machine affects many of them alike.
  for (int repeat = 0; repeat < arguments.repeats; ++repeat) {
    for (std::size_t i = 0; i < settings.size(); ++i) {
      const std::string place = "repeat " + std::to_string(repeat + 1) + " of " +
                                std::to_string(arguments.repeats) + ", setting " +
                                std::to_string(i + 1) + " of " + std::to_string(settings.size()) +
                                ": " + describe(settings[i]) + ": ";
      const double all = static_cast<double>(settings.size()) * arguments.repeats;
      progress->setDone((static_cast<double>(settings.size()) * repeat + static_cast<double>(i)) /
                        all);
      Measurement& sum = results.measurements[i];
      sum.setting = settings[i];
      const std::unique_ptr<Detector> detector = makeBackend(settings[i].backend);
      measure(
          frames, results.exact, cycles, detector.get(),
          [&](const std::string& what) { progress->set(place + what); }, &sum);
    }
  }
  progress->setDone(1);
  // All settings are compared only after everything was measured.
  std::vector<Worth> worth;
  for (const Measurement& m : results.measurements) worth.push_back(m.worth());
  results.front = paretoFront(worth);
  results.chosen = choose(worth, arguments.budget_ms);
  results.fastest = fastest(worth);
  if (results.chosen)
    results.chosen = defaultsIfAsGood(results.measurements, *results.chosen, arguments.budget_ms);
  if (results.chosen) results.as_fast = asFast(worth, *results.chosen);
  return results;
}

// Prints a note if triangles were rejected over all frames. `so` says what follows.
void noteRejected(std::uint64_t rejected, const char* so = "") {
  if (rejected == 0) return;
  note(std::to_string(rejected) +
       " triangles, over all frames, have a NaN or infinite vertex and took no part" + so);
}

// Warns about pairs without an interval, and about invalid triangles.
void warnMotions(const MotionResults& found) {
  if (found.pairs_without_step > 0) {
    note(std::to_string(found.pairs_without_step) +
         " pairs of bodies, over all frames, were not looked at or had other triangles in the "
         "frame before, or came from where nobody knows, so they have no step there");
  }
  noteRejected(found.rejected);
}

// Measures what instant motion loses. Returns the exit code.
int runSwept(const TradeArguments& arguments) {
  std::string text;
  MotionResults found;
  withFrames(arguments, [&](FrameSource* frames, Progress* progress) {
    OutputFile motions = outputOf(arguments, "motions.csv");
    OutputFile onsets = outputOf(arguments, "onsets.csv");
    OutputFile summary = outputOf(arguments, "summary.json");
    found = findMotions(
        frames, static_cast<std::size_t>(arguments.every), arguments.base,
        [&] { return makeBackend(arguments.grid.backends.front()); },
        [&](const std::string& what) { progress->set(what); });
    progress->set("counting");
    const std::vector<MotionCounts> levels = {countMotions(found, MotionLevel::kBodies),
                                              countMotions(found, MotionLevel::kTriangles)};
    progress->set("writing");
    motions.write(motionsCsv(found, levels));
    onsets.write(onsetsCsv(found, levels, *frames));
    summary.write(motionJson(arguments, found, levels, *frames));
    drawPlots(arguments, "plot_motion.py", progress);
    text = motionText(found, levels);
  });
  warnMotions(found);
  OutputFile("-").write(text);
  return 0;
}

// Returns exact detection on the CPU first, then the other backends and overlaps, then each
// tolerance with each budget.
std::vector<BoundSetting> boundSettings(const TradeArguments& arguments) {
  std::vector<BoundSetting> settings = {BoundSetting()};
  for (const std::string& backend : arguments.grid.backends) {
    if (backend != "cpu") settings.push_back({0, 0, backend, 1});
  }
  for (const float overlap : arguments.grid.overlaps) {
    if (overlap < 1) settings.push_back({0, 0, "cpu", overlap});
  }
  for (const float tolerance_m : arguments.tolerances_m) {
    for (const double budget_ms : arguments.budgets_ms) {
      const BoundSetting setting{tolerance_m, budget_ms, "cpu", 1};
      if (setting.isBounded()) settings.push_back(setting);
    }
  }
  return settings;
}

// Finds the exact contacts, then measures each setting against them.
std::vector<BoundMeasurement> measureAllBounds(const TradeArguments& arguments, FrameSource* frames,
                                               Progress* progress) {
  const std::vector<BoundSetting> settings = boundSettings(arguments);
  for (const BoundSetting& setting : settings)
    makeBackend(setting.backend);  // fails now if missing
  const TouchingPairs truth = touchingBodies(frames, makeBackend("cpu").get(), arguments.base,
                                             [&](const std::string& what) { progress->set(what); });
  return measureEach<BoundMeasurement>(
      arguments, settings, truth.size(), progress,
      [&](BoundMeasurement* m, const CycleCounts& cycles) {
        const auto tilings = m->setting.isBounded() ? std::make_shared<TilingCache>() : nullptr;
        measureBounds(frames, truth, cycles, arguments.base,
                      makeBackend(m->setting.backend, tilings).get(), tilings.get(), m);
      });
}

// Measures tolerances and budgets. Returns the exit code.
int runBounds(const TradeArguments& arguments) {
  std::vector<BoundMeasurement> all;
  withFrames(arguments, [&](FrameSource* frames, Progress* progress) {
    OutputFile table = outputOf(arguments, "bounds.csv");
    OutputFile summary = outputOf(arguments, "summary.json");
    std::optional<OutputFile> config = configOf(arguments);
    all = measureAllBounds(arguments, frames, progress);
    progress->set("writing");
    table.write(boundsCsv(arguments, all));
    summary.write(boundsJson(arguments, all, *frames));
    if (config) config->write(boundsYaml(arguments, all, *frames));
    drawPlots(arguments, "plot_bounds.py", progress);
  });
  if (all.front().contacts.truth == 0) note(kNoContact);
  noteRejected(all.front().rejected, ", so their bodies are UNKNOWN unless they touch");
  const int code = exitCode(all, "PROMISE");
  if (arguments.config_file != "-") OutputFile("-").write(boundsText(arguments, all));
  return code;
}

// Returns contacts alone first, then both uses of each margin, for each backend.
std::vector<MarginSetting> marginSettings(const TradeArguments& arguments) {
  std::vector<MarginSetting> settings;
  for (const std::string& backend : arguments.grid.backends) {
    settings.push_back({backend, 0, MarginUse::kIgnored});
    for (const float margin_m : arguments.margins_m) {
      settings.push_back({backend, margin_m, MarginUse::kNearPairs});
      settings.push_back({backend, margin_m, MarginUse::kNearest});
    }
  }
  return settings;
}

// Measures each setting, and compares the distances of the search with those of the list.
std::vector<MarginMeasurement> measureAllMargins(const TradeArguments& arguments,
                                                 FrameSource* frames, Progress* progress) {
  const std::vector<MarginSetting> settings = marginSettings(arguments);
  for (const MarginSetting& setting : settings) makeBackend(setting.backend);  // fails now
  std::size_t frame_count = 0;
  for (frames->rewind(); frames->next();) ++frame_count;
  FrameDistances of_list;
  return measureEach<MarginMeasurement>(
      arguments, settings, frame_count, progress,
      [&](MarginMeasurement* m, const CycleCounts& cycles) {
        FrameDistances found =
            measureMargin(frames, cycles, arguments.base, makeBackend(m->setting.backend).get(), m);
        if (m->setting.use == MarginUse::kNearest) compareDistances(of_list, found, m);
        if (m->setting.use == MarginUse::kNearPairs) of_list = std::move(found);
      });
}

// Measures margins. Returns the exit code.
int runMargins(const TradeArguments& arguments) {
  std::vector<MarginMeasurement> all;
  withFrames(arguments, [&](FrameSource* frames, Progress* progress) {
    OutputFile table = outputOf(arguments, "margins.csv");
    OutputFile summary = outputOf(arguments, "summary.json");
    all = measureAllMargins(arguments, frames, progress);
    progress->set("writing");
    table.write(marginsCsv(arguments, all));
    summary.write(marginsJson(arguments, all, *frames));
  });
  noteRejected(all.front().rejected, ": of their bodies, pairs may be missing");
  const int code = exitCode(all, "PROMISE");
  OutputFile("-").write(marginsText(arguments, all));
  return code;
}

// Measures states of a robot. Returns the exit code.
int runStates(const TradeArguments& arguments) {
  std::vector<StateMeasurement> all;
  {
    Progress progress("reading the robot");
    const SceneStates states = makeRobotStates(
        {arguments.urdf, arguments.meshes.states.front(), arguments.states_margin_m},
        static_cast<std::size_t>(arguments.states), 1);
    makeFolder(arguments.out_folder);
    OutputFile table = outputOf(arguments, "states.csv");
    OutputFile summary = outputOf(arguments, "summary.json");
    const std::vector<bool> touches = exactTouches(states);
    for (StateWay& way : stateWays(arguments.grid.backends, arguments.base.threads)) {
      for (const std::size_t batch : batchSizes(way, states.count())) {
        progress.set("measuring " + way.name + ", batches of " + std::to_string(batch));
        all.push_back(measureStates(states, touches, batch, arguments.repeats, &way));
      }
    }
    progress.set("writing");
    table.write(statesCsv(all));
    summary.write(statesJson(arguments.command, states, touches, all));
    drawPlots(arguments, "plot_states.py", &progress);
  }
  OutputFile("-").write(statesText(all));
  return 0;
}

// Measures the grid of settings. Returns the exit code.
int run(const TradeArguments& arguments) {
  TradeResults results;
  withFrames(arguments, [&](FrameSource* frames, Progress* progress) {
    OutputFile settings = outputOf(arguments, "settings.csv");
    OutputFile links = outputOf(arguments, "links.csv");
    OutputFile summary = outputOf(arguments, "summary.json");
    std::optional<OutputFile> config = configOf(arguments);
    results = measureAll(arguments, frames, progress);
    progress->set("writing");
    settings.write(settingsCsv(results));
    links.write(linksCsv(results, *frames));
    summary.write(summaryJson(arguments, results, *frames));
    if (config && results.chosen) config->write(configYaml(arguments, results, *frames));
    drawPlots(arguments, "plot_trade.py", progress);
  });
  if (results.exact.bodies.empty()) note(kNoContact);
  noteRejected(results.exact.rejected, ": contacts of them are missed, and no figure counts them");
  const int code = exitCode(results.measurements, "GUARANTEE");
  // Standard output holds either the configuration or the choice, but not both.
  if (arguments.config_file != "-") OutputFile("-").write(choiceText(arguments, results));
  if (code == 0 && !results.chosen && !arguments.config_file.empty()) {
    throw std::runtime_error(arguments.config_file + ": there is no setting to write");
  }
  return code;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runTool("measure_trade", [argc, argv] {
    dcm::TradeArguments arguments;
    if (!dcm::parseArguments(argc, argv, &arguments)) return 0;
    if (arguments.bounds) return dcm::runBounds(arguments);
    if (arguments.margins) return dcm::runMargins(arguments);
    if (arguments.states > 0) return dcm::runStates(arguments);
    return arguments.swept ? dcm::runSwept(arguments) : dcm::run(arguments);
  });
}
