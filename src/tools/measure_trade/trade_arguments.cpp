// The command line of measure_trade.
#include "tools/measure_trade/trade_arguments.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <vector>

#include "tools/common/command_line.h"
#include "tools/common/output_file.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kDescription =
    "Measures what each setting of the detector costs and finds on a scene, against the exact "
    "contacts. STATE files are the states, in order, of one deforming body; the others stand "
    "still. Lists are comma-separated: overlaps, predicates and clusters are combined in full; of "
    "the other lists the first value is used there, and each of the rest once by itself.";
constexpr const char* kFooter =
    "Writes settings.csv, links.csv, summary.json and plots (PNG), and says which setting it would "
    "use. Times are round trips: scene on the host to sorted contacts there.\n"
    "Exit code: 0; 1 if a setting that is guaranteed to be exact was not; 2 with one line on "
    "standard error (bad usage, an unreadable mesh, no setting within the budget to write).";

std::string quoted(const std::string& word) {
  const char* const plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./,:=+@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

template <class Value>
void addList(CLI::App* app, const std::string& name, std::vector<Value>* values,
             const std::string& help) {
  const auto not_empty = [](const std::string& text) {
    return text.empty() ? std::string("has an empty value") : std::string();
  };
  app->add_option(name, *values, help)->delimiter(',')->check(not_empty)->capture_default_str();
}

void addScene(CLI::App* app, TradeArguments* arguments) {
  MeshFrameFiles& meshes = arguments->meshes;
  auto* states = app->add_option("STATE", meshes.states, "Mesh files: OBJ, PLY, STL or OFF");
  auto* against = app->add_option("--against", meshes.against,
                                  "Mesh files, each a body that stands still, as a robot's link");
  auto* self = app->add_flag("--self", meshes.self, "Also contacts of the body with itself");
  BagFiles& recorded = arguments->recorded;
  auto* bags = app->add_option("--bag", recorded.bags, "Recorded bags instead of mesh files")
                   ->excludes(states)
                   ->excludes(against)
                   ->excludes(self);
  app->add_option("--config", recorded.config, "With --bag: parameters of contact_monitor, yaml")
      ->needs(bags);
  app->add_option("--robot-description", recorded.robot_description,
                  "With --bag: URDF, or a rosparam dump of it, unless the bags have the robot")
      ->needs(bags);
  app->add_option("--reference-frame", recorded.reference_frame,
                  "With --bag: frame of the contacts, instead of the configuration's")
      ->needs(bags);
}

void addRun(CLI::App* app, TradeArguments* arguments) {
  app->add_option("--threads", arguments->base.threads, "Threads of the cpu backend; 0: all cores")
      ->capture_default_str();
  app->add_option("--cycles", arguments->least_cycles,
                  "Measure at least so many cycles of each setting, in whole passes through the "
                  "states (default: 20)")
      ->check(CLI::Range(1, 1000000000));
  app->add_option("--warm-up", arguments->warm_up, "Cycles before them that are not counted")
      ->check(CLI::Range(0, 1000000000))
      ->capture_default_str();
  app->add_option("--out", arguments->out_folder, "Folder for the results; made if need be")
      ->capture_default_str();
  app->add_option("--budget-ms", arguments->budget_ms,
                  "Choose the most accurate setting that takes no longer in 95 of 100 cycles "
                  "(default: the fastest of those that are guaranteed)");
  app->add_option("--write-config", arguments->config_file,
                  "Write the chosen setting here, as parameters of contact_monitor (YAML)");
}

std::vector<Predicates> predicatesFrom(const std::vector<std::string>& names) {
  std::vector<Predicates> all;
  all.reserve(names.size());
  for (const std::string& name : names) all.push_back(toPredicates(name));
  return all;
}

void check(const TradeArguments& arguments) {
  const MeshFrameFiles& meshes = arguments.meshes;
  if (arguments.recorded.bags.empty()) {
    if (meshes.states.empty()) refuseUsage("STATE: a mesh file, or --bag, is required");
    if (meshes.against.empty() && !meshes.self) {
      refuseUsage("there is nothing to test: no --against and no --self");
    }
  }
  for (const Setting& setting : settingsOf(arguments.grid, arguments.base)) {
    const std::vector<std::string> found = problems(setting.options);
    if (!found.empty()) refuseUsage(found.front());
  }
  if (arguments.budget_ms && !(std::isfinite(*arguments.budget_ms) && *arguments.budget_ms > 0)) {
    refuseUsage("--budget-ms: must be a finite number > 0");
  }
  if (arguments.out_folder.empty()) refuseUsage("--out: must not be empty");
  refuseMeshAsOutput("--write-config", arguments.config_file);
}

}  // namespace

bool parseArguments(int argc, char** argv, TradeArguments* arguments) {
  CLI::App app(kDescription, "measure_trade");
  app.footer(kFooter);
  app.set_version_flag("--version", "measure_trade " DCM_VERSION);
  arguments->base.threads = 1;
  TradeGrid& grid = arguments->grid;
  std::vector<std::string> predicates = {"exact", "conservative", "fast"};
  addScene(&app, arguments);
  addAdjacent(&app, &arguments->base.adjacent);
  addList(&app, "--backends", &grid.backends, "Of cpu, cuda");
  app.get_option("--backends")->check(CLI::IsMember({"cpu", "cuda"}));
  addList(&app, "--overlaps", &grid.overlaps, "In [0, 1]");
  addList(&app, "--predicates", &predicates, "Of exact, conservative, fast");
  app.get_option("--predicates")->check(CLI::IsMember({"exact", "conservative", "fast"}));
  addList(&app, "--clusters", &grid.clusters, "0: from the scene");
  addList(&app, "--fuzzifiers", &grid.fuzzifiers, "In [1.05, 4]");
  addList(&app, "--iterations", &grid.iterations, "In [0, 100]");
  addList(&app, "--refresh-periods", &grid.refresh_periods, "In cycles, >= 1");
  addRun(&app, arguments);
  if (!parsed(&app, argc, argv)) return false;
  grid.predicates = predicatesFrom(predicates);
  for (int i = 0; i < argc; ++i) {
    arguments->command += (i == 0 ? "" : " ") + quoted(i == 0 ? "measure_trade" : argv[i]);
  }
  check(*arguments);
  return true;
}

}  // namespace deformable_contact_monitor
