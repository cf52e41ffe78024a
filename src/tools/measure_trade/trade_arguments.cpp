// Declares and checks the command line of measure_trade. Each add function declares one group of
// options, and the rules between them; check() tests what rules between options cannot.
#include "tools/measure_trade/trade_arguments.h"

#include <filesystem>

#include "tools/common/command_line.h"
#include "tools/common/output_file.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kDescription =
    "Measures the time and the accuracy of the detector's settings on a scene, against the exact "
    "contacts. STATE files are the states of one deforming body, in order; the other bodies do not "
    "move. Lists are separated by commas. All combinations of overlaps, predicates and clusters "
    "are measured, with the first value of the other lists; their other values are measured once.";
constexpr const char* kFooter =
    "Writes settings.csv, links.csv, summary.json and plots (PNG), and says which setting it "
    "chooses. Times are round trips: from a scene on the host to sorted contacts on the host.\n"
    "Exit code: 0: done; 1: a setting that is guaranteed to be exact was not; 2: bad usage, an "
    "unreadable mesh, or no setting within the budget to write. With 2, one line on standard error "
    "says why.";

// Quotes a word for a shell.
std::string quoted(const std::string& word) {
  const char* const plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./,:=+@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

// Adds the options that say what is measured on.
void addScene(CommandLine* line, TradeArguments* arguments) {
  MeshFrameFiles& meshes = arguments->meshes;
  line->addPositionals("STATE", &meshes.states, false, "Mesh files: OBJ, PLY, STL or OFF");
  line->addWords("--against", &meshes.against,
                 "Mesh files, each a body that does not move, such as a robot's link");
  line->addFlag("--self", &meshes.self, "Also measure self-contacts of the deforming body");
  BagFiles& recorded = arguments->recorded;
  line->addWords("--bag", &recorded.bags,
                 "Recorded bags instead of mesh files, without --against and --self");
  for (const char* other : {"STATE", "--against", "--self"}) line->refuseTogether("--bag", other);
  describe(line, &recorded, "--bag");
  line->add("--adjacent", &arguments->base.adjacent, kAdjacentHelp);
}

// Adds the options that say which settings are tried.
void addGrid(CommandLine* line, TradeGrid* grid, std::vector<std::string>* predicates) {
  line->addList("--backends", &grid->backends, "Backends to measure; each", oneOf({"cpu", "cuda"}));
  line->addList("--overlaps", &grid->overlaps, "Overlaps to measure; each in [0, 1]");
  line->addList("--predicates", predicates, "Predicates to measure; each",
                oneOf({"exact", "conservative"}));
  line->addList("--clusters", &grid->clusters,
                "Numbers of clusters to measure; 0: chosen from the scene");
  line->addList("--fuzzifiers", &grid->fuzzifiers, "Fuzzifiers to measure; each in [1.05, 4]");
  line->addList("--iterations", &grid->iterations,
                "Fuzzy c-means iterations per refresh to measure; each in [0, 100]");
  line->addList("--refresh-periods", &grid->refresh_periods,
                "Cycles between refreshes of the clusters to measure; each >= 1");
}

// Adds the options that say how long to measure and what to write.
void addRun(CommandLine* line, TradeArguments* arguments) {
  line->add("--threads", &arguments->base.threads, "Threads of the cpu backend; 0: all cores");
  line->add("--cycles", &arguments->least_cycles,
            "Least number of cycles of each setting; whole passes through the states are measured",
            inRange(1, 1000000000));
  line->add("--repeats", &arguments->repeats,
            "Divide the cycles among so many passes through all settings, to measure the noise",
            inRange(1, 1000));
  line->add("--warm-up", &arguments->warm_up,
            "Cycles at the start of each repeat that are not counted", inRange(0, 1000000000));
  line->add(
      "--frames", &arguments->most_frames,
      "With --bag: most cycles of the bags that are measured, spread evenly over them; 0: all",
      inRange(0, 1000000000));
  line->requireFor("--frames", "--bag");
  line->add("--out", &arguments->out_folder, "Folder for the results; it is made if it is missing");
  line->add("--budget-ms", &arguments->budget_ms,
            "Choose the most accurate setting that takes at most this time in 95 of 100 cycles; "
            "without a budget, the fastest setting with a guarantee",
            isPositive());
  line->add("--write-config", &arguments->config_file,
            "File for the chosen setting, as parameters of contact_monitor (yaml)");
  line->addFlag("--force", &arguments->force, "Replace an existing file of --write-config");
  line->requireFor("--force", "--write-config");
  line->addFlag(
      "--write-budget", &arguments->writes_budget,
      "Also write --budget-ms, as budget_ms. The node's budget counts from the arrival of a "
      "mesh, so it includes the wait for transforms: pairs that are not decided by then are "
      "UNKNOWN");
  for (const char* option : {"--budget-ms", "--write-config", "--tolerance"}) {
    line->requireFor("--write-budget", option);
  }
}

// Options that only the grid has.
constexpr const char* kGridOptions[] = {"--overlaps",        "--predicates", "--clusters",
                                        "--fuzzifiers",      "--iterations", "--cycles",
                                        "--refresh-periods", "--warm-up",    "--budget-ms",
                                        "--write-config",    "--frames"};

// Adds the options of --swept.
void addSwept(CommandLine* line, TradeArguments* arguments) {
  line->addFlag(
      "--swept", &arguments->swept,
      "Measure instead which contacts and onsets are lost if only the frames are checked, "
      "or only some of them; writes motions.csv, onsets.csv, summary.json and plots");
  line->add("--every", &arguments->every, "With --swept: keep every n-th frame and the last",
            inRange(2, 1000000));
  line->add("--split", &arguments->meshes.split,
            "With --swept: divide the path between two STATE files into so many straight steps",
            inRange(1, 1000));
  for (const char* option : {"--every", "--split"}) line->requireFor(option, "--swept");
  line->refuseTogether("--bag", "--split");
  for (const char* option : kGridOptions) line->refuseTogether("--swept", option);
}

// Adds the options of --tolerance.
void addBounds(CommandLine* line, TradeArguments* arguments) {
  line->addFlag(
      "--tolerance", &arguments->bounds,
      "Measure instead what tolerances and time budgets cost on the CPU, and how the states "
      "of pairs of bodies compare with exact --backends and with --overlaps below 1; "
      "writes bounds.csv, summary.json and a plot");
  line->addList("--tolerances-m", &arguments->tolerances_m,
                "With --tolerance: largest errors of distances [m]; each", inRange(0.F, 1.F));
  line->addList("--budgets-ms", &arguments->budgets_ms,
                "With --tolerance: time limits of a detection [ms]; 0: none; each",
                inRange(0.0, 60000.0));
  for (const char* option : {"--tolerances-m", "--budgets-ms"}) {
    line->requireFor(option, "--tolerance");
  }
  for (const char* option : {"--swept", "--predicates", "--clusters", "--fuzzifiers",
                             "--iterations", "--refresh-periods", "--repeats"}) {
    line->refuseTogether("--tolerance", option);
  }
}

// Adds the options of --margins.
void addMargins(CommandLine* line, TradeArguments* arguments) {
  line->addFlag("--margins", &arguments->margins,
                "Measure instead what margins cost: the search for the nearest triangles of each "
                "two bodies, beside the list of all triangles within the margin; writes "
                "margins.csv and summary.json");
  line->addList("--margins-m", &arguments->margins_m, "With --margins: margins [m]; each",
                inRange(0.F, 10.F));
  line->requireFor("--margins-m", "--margins");
  for (const char* option :
       {"--swept", "--tolerance", "--overlaps", "--predicates", "--clusters", "--fuzzifiers",
        "--iterations", "--refresh-periods", "--repeats", "--budget-ms", "--write-config"}) {
    line->refuseTogether("--margins", option);
  }
}

// Adds the options of --states.
void addStates(CommandLine* line, TradeArguments* arguments) {
  line->add(
      "--states", &arguments->states,
      "Measure instead what a state of the robot of --urdf beside the mesh STATE costs, by the "
      "number of states that are asked at once, beside FCL and spheres: so many random ones; "
      "writes states.csv, summary.json and a plot; 0: measure the grid",
      inRange(0, 1000000));
  line->add("--urdf", &arguments->urdf,
            "With --states: the robot; its root link is the frame of the mesh");
  line->add("--states-margin-m", &arguments->states_margin_m,
            "With --states: nearest pairs are searched within this distance [m]",
            inRange(0.F, 10.F));
  for (const char* option : {"--urdf", "--states-margin-m"}) line->requireFor(option, "--states");
  line->requireFor("--states", "--urdf");
  for (const char* option :
       {"--swept", "--tolerance", "--margins", "--overlaps", "--predicates", "--clusters",
        "--fuzzifiers", "--iterations", "--refresh-periods", "--cycles", "--warm-up", "--budget-ms",
        "--write-config", "--bag", "--against", "--self"}) {
    line->refuseTogether("--states", option);
  }
}

// Converts names that the option's rule has checked.
std::vector<Predicates> predicatesFrom(const std::vector<std::string>& names) {
  std::vector<Predicates> all;
  all.reserve(names.size());
  for (const std::string& name : names) all.push_back(toPredicates(name));
  return all;
}

// Checks what the options' own rules cannot. Throws as refuseUsage() does.
void check(const TradeArguments& arguments) {
  const MeshFrameFiles& meshes = arguments.meshes;
  if (arguments.recorded.bags.empty()) {
    if (meshes.states.empty()) refuseUsage("STATE: a mesh file, or --bag, is required");
    if (arguments.states > 0 && meshes.states.size() != 1) {
      refuseUsage("STATE: --states takes one mesh file");
    }
    if (meshes.against.empty() && !meshes.self && arguments.states == 0) {
      refuseUsage("there is nothing to test: no --against and no --self");
    }
    if (arguments.bounds && meshes.against.empty()) {
      refuseUsage("--tolerance: is about pairs of two bodies, so --against is required");
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

// The command is kept, so that results say how they were made.
bool parseArguments(int argc, char** argv, TradeArguments* arguments) {
  CommandLine line("measure_trade", kDescription, kFooter);
  arguments->base.threads = 1;
  TradeGrid& grid = arguments->grid;
  std::vector<std::string> predicates = {"exact", "conservative"};
  addScene(&line, arguments);
  addGrid(&line, &grid, &predicates);
  addRun(&line, arguments);
  addSwept(&line, arguments);
  addBounds(&line, arguments);
  addMargins(&line, arguments);
  addStates(&line, arguments);
  if (!line.parse(argc, argv)) return false;
  grid.predicates = predicatesFrom(predicates);
  for (int i = 0; i < argc; ++i) {
    arguments->command += (i == 0 ? "" : " ") + quoted(i == 0 ? "measure_trade" : argv[i]);
  }
  check(*arguments);
  return true;
}

}  // namespace deformable_contact_monitor
