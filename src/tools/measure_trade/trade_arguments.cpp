// The command line of measure_trade.
#include "tools/measure_trade/trade_arguments.h"

#include <filesystem>
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

void addScene(CommandLine* line, TradeArguments* arguments) {
  MeshFrameFiles& meshes = arguments->meshes;
  line->addPositionals("STATE", &meshes.states, false, "Mesh files: OBJ, PLY, STL or OFF");
  line->addWords("--against", &meshes.against,
                 "Mesh files, each a body that stands still, as a robot's link");
  line->addFlag("--self", &meshes.self, "Also contacts of the body with itself");
  BagFiles& recorded = arguments->recorded;
  line->addWords("--bag", &recorded.bags,
                 "Recorded bags instead of mesh files, without --against and --self");
  for (const char* other : {"STATE", "--against", "--self"}) line->refuseTogether("--bag", other);
  line->add("--config", &recorded.config, "With --bag: parameters of contact_monitor, yaml");
  line->add("--robot-description", &recorded.robot_description,
            "With --bag: URDF, or a rosparam dump of it, unless the bags have the robot");
  line->add("--reference-frame", &recorded.reference_frame,
            "With --bag: frame of the contacts, instead of the configuration's");
  for (const char* option : {"--config", "--robot-description", "--reference-frame"}) {
    line->requireFor(option, "--bag");
  }
  line->add("--adjacent", &arguments->base.adjacent, kAdjacentHelp);
}

void addGrid(CommandLine* line, TradeGrid* grid, std::vector<std::string>* predicates) {
  line->addList("--backends", &grid->backends, "Each", oneOf({"cpu", "cuda"}));
  line->addList("--overlaps", &grid->overlaps, "Each in [0, 1]");
  line->addList("--predicates", predicates, "Each", oneOf({"exact", "conservative", "fast"}));
  line->addList("--clusters", &grid->clusters, "0: from the scene");
  line->addList("--fuzzifiers", &grid->fuzzifiers, "Each in [1.05, 4]");
  line->addList("--iterations", &grid->iterations, "Each in [0, 100]");
  line->addList("--refresh-periods", &grid->refresh_periods, "In cycles, each >= 1");
}

void addRun(CommandLine* line, TradeArguments* arguments) {
  line->add("--threads", &arguments->base.threads, "Threads of the cpu backend; 0: all cores");
  line->add("--cycles", &arguments->least_cycles,
            "Measure at least so many cycles of each setting, in whole passes through the states",
            inRange(1, 1000000000));
  line->add("--repeats", &arguments->repeats,
            "Share these cycles out over so many passes through all settings, to see the noise",
            inRange(1, 1000));
  line->add("--warm-up", &arguments->warm_up,
            "Cycles before them, in each repeat, that are not counted", inRange(0, 1000000000));
  line->add("--out", &arguments->out_folder, "Folder for the results; made if need be");
  line->add("--budget-ms", &arguments->budget_ms,
            "Choose the most accurate setting that takes no longer in 95 of 100 cycles "
            "(else: the fastest of those that are guaranteed)",
            isPositive());
  line->add("--write-config", &arguments->config_file,
            "Write the chosen setting here, as parameters of contact_monitor (YAML)");
  line->addFlag("--force", &arguments->force, "Replace the file that --write-config names");
  line->requireFor("--force", "--write-config");
}

// What is of the grid alone.
constexpr const char* kGridOptions[] = {
    "--overlaps", "--predicates",      "--clusters", "--fuzzifiers", "--iterations",
    "--cycles",   "--refresh-periods", "--warm-up",  "--budget-ms",  "--write-config"};

void addSwept(CommandLine* line, TradeArguments* arguments) {
  line->addFlag("--swept", &arguments->swept,
                "Measure instead which contacts, and which of their onsets, are lost where frames "
                "are looked at one by one, and at some of them alone; writes motions.csv, "
                "onsets.csv, summary.json and plots");
  line->add("--every", &arguments->every, "With --swept: keep each so-many-th frame and the last",
            inRange(2, 1000000));
  line->add("--split", &arguments->meshes.split,
            "With --swept: cut the step between two STATE files into so many, on straight lines",
            inRange(1, 1000));
  for (const char* option : {"--every", "--split"}) line->requireFor(option, "--swept");
  line->refuseTogether("--bag", "--split");
  for (const char* option : kGridOptions) line->refuseTogether("--swept", option);
}

void addBounds(CommandLine* line, TradeArguments* arguments) {
  line->addFlag("--tolerance", &arguments->bounds,
                "Measure instead what tolerances and budgets cost on the CPU, and what they say of "
                "pairs of two bodies, beside exact --backends and --overlaps below 1; writes "
                "bounds.csv, summary.json and a plot");
  line->addList("--tolerances-m", &arguments->tolerances_m,
                "With --tolerance: how far off distances may be, each", inRange(0.F, 1.F));
  line->addList("--budgets-ms", &arguments->budgets_ms,
                "With --tolerance: after how long a detection ends; 0: never; each",
                inRange(0.0, 60000.0));
  for (const char* option : {"--tolerances-m", "--budgets-ms"}) {
    line->requireFor(option, "--tolerance");
  }
  for (const char* option : {"--swept", "--predicates", "--clusters", "--fuzzifiers",
                             "--iterations", "--refresh-periods", "--repeats"}) {
    line->refuseTogether("--tolerance", option);
  }
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
  if (arguments.swept && arguments.grid.backends.size() != 1) {
    refuseUsage("--backends: --swept takes one");
  }
  for (const Setting& setting : settingsOf(arguments.grid, arguments.base)) {
    const std::vector<std::string> found = problems(setting.options);
    if (!found.empty()) refuseUsage(found.front());
  }
  if (arguments.out_folder.empty()) refuseUsage("--out: must not be empty");
  refuseMeshAsOutput("--write-config", arguments.config_file);
  if (!arguments.force && std::filesystem::is_regular_file(arguments.config_file)) {
    refuseUsage("--write-config: " + arguments.config_file +
                " is there already; --force replaces it");
  }
}

}  // namespace

bool parseArguments(int argc, char** argv, TradeArguments* arguments) {
  CommandLine line("measure_trade", kDescription, kFooter);
  arguments->base.threads = 1;
  TradeGrid& grid = arguments->grid;
  std::vector<std::string> predicates = {"exact", "conservative", "fast"};
  addScene(&line, arguments);
  addGrid(&line, &grid, &predicates);
  addRun(&line, arguments);
  addSwept(&line, arguments);
  addBounds(&line, arguments);
  if (!line.parse(argc, argv)) return false;
  grid.predicates = predicatesFrom(predicates);
  for (int i = 0; i < argc; ++i) {
    arguments->command += (i == 0 ? "" : " ") + quoted(i == 0 ? "measure_trade" : argv[i]);
  }
  check(*arguments);
  return true;
}

}  // namespace deformable_contact_monitor
