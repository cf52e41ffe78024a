// Declares and checks the command line of detect_contacts. CommandLine checks single values; this
// file checks what depends on several options, and converts texts to the core's types.
#include "tools/detect_contacts/detect_arguments.h"

#include <charconv>
#include <cstdint>
#include <system_error>
#include <utility>

#include "tools/common/backend_choice.h"
#include "tools/common/command_line.h"
#include "tools/common/output_file.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kDescription =
    "Finds every contact between the triangles of mesh files: OBJ, PLY, STL or OFF, each file one "
    "body, numbered from 0, in one frame. Triangles are numbered in file order from 0.";
constexpr const char* kFooter =
    "Exit code: 0, or 2 with one line on standard error (bad usage, an unreadable mesh).";

// Reads --clusters: "auto" is 0, which lets the detector choose. Throws on anything else that is
// not a number of at least 1; problems() checks the upper limit.
int clustersFrom(const std::string& text) {
  if (text == "auto") return 0;
  int clusters = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, clusters);
  if (parsed.ec != std::errc() || parsed.ptr != end || clusters < 1) {
    refuseUsage("--clusters: '" + text + "' is neither auto nor a number in [1, " +
                std::to_string(kMaxClusters) + "]");
  }
  return clusters;
}

// Adds the options whose values go into `arguments` directly. Their present values are the
// defaults.
void addOptions(CommandLine* line, DetectArguments* arguments) {
  Options& options = arguments->options;
  line->addPositionals("MESH", &arguments->meshes, true, "Mesh files");
  line->addFlag("--self", &arguments->self, "Also find contacts of every body with itself");
  line->add("--backend", &arguments->backend, "What runs the detection", oneOf(backendNames()));
  line->add("--device", &arguments->cuda.device, "CUDA device to use", inRange(0, 1023));
  line->addList("--devices", &arguments->cuda.devices,
                "CUDA devices that share the work on large scenes, in place of --device; each",
                inRange(0, 1023));
  line->add("--overlap", &options.overlap,
            "Share of a triangle that decides its clusters, in [0, 1]; 1 finds every contact");
  line->add("--margin", &arguments->margin_m,
            "Report triangles at this distance or less, in the meshes' unit");
  line->add(
      "--parts", &arguments->parts_file,
      "Read parts of bodies, and which of their pairs are left out, from here: lines 'part "
      "BODY NAME FIRST-LAST...', 'group BODY NAME GROUP...' and 'skip BODY:NAME BODY[:NAME]'");
  line->add(
      "--tolerance-m", &options.tolerance_m,
      "Say of each pair of bodies whether it is in contact, off by at most this distance, and "
      "list the contacts seen on the way alone; 0: exact");
  line->add("--budget-ms", &arguments->budget_ms,
            "End each detection after so long; what is not decided is unknown", isPositive());
  // The bounds of distances hold at one moment, not over an interval.
  for (const char* option : {"--tolerance-m", "--budget-ms"}) {
    line->refuseTogether("--swept", option);
  }
  line->add("--repeat", &arguments->repeat, "Detect this often, for the times",
            inRange(1, 1000000000));
  line->add("--threads", &options.threads, "Threads of the cpu backend; 0: all cores");
  line->add("--fuzzifier", &options.fuzzifier, "Fuzzifier of fuzzy c-means, in [1.05, 4]");
  line->add("--iterations", &options.iterations,
            "Iterations of fuzzy c-means in a refresh, in [0, 100]");
  line->add("--refresh-period", &options.refresh_period, "Cycles between refreshes");
  line->add("--pairs", &arguments->pairs_file,
            "Write a line 'bodyA triA bodyB triB' for each contact, sorted, here (-: standard "
            "output)");
  line->add("--times", &arguments->times_file,
            "Write a line 'bodyA triA bodyB triB first_low first_high' for each contact here (-: "
            "standard output); needs --swept");
  line->add("--geometry", &arguments->geometry_file,
            "Write a line 'bodyA triA bodyB triB ax ay az bx by bz nx ny nz separation flags' for "
            "each contact here (-: standard output)");
  line->add("--nearest", &arguments->nearest_file,
            "Write a line 'bodyA triA bodyB triB distance' for each two bodies at most --margin "
            "apart, with their nearest triangles, here (-: standard output); contacts are then "
            "those that touch");
  line->addFlag("--near-pairs", &options.near_pairs,
                "With --nearest, also list as contacts all triangles within --margin");
  line->requireFor("--nearest", "--margin");
  line->requireFor("--near-pairs", "--nearest");
  line->add("--json", &arguments->json_file,
            "Write counts, options and milliseconds here (-: standard output)");
  line->add("--adjacent", &options.adjacent, kAdjacentHelp);
}

// Rejects the name of an input as an output, which is most often a forgotten argument, and two
// outputs to the same file.
void refuseOutputs(const DetectArguments& arguments) {
  const std::pair<std::string, std::string> outputs[] = {{"--pairs", arguments.pairs_file},
                                                         {"--times", arguments.times_file},
                                                         {"--geometry", arguments.geometry_file},
                                                         {"--nearest", arguments.nearest_file},
                                                         {"--json", arguments.json_file}};
  for (const auto& [option, file] : outputs) {
    refuseMeshAsOutput(option, file);
    if (!file.empty() && file == arguments.parts_file) {
      refuseUsage(option + ": would write over " + file + ", which --parts reads");
    }
    for (const auto& [other, other_file] : outputs) {
      if (option == other) break;
      if (file.empty() || file != other_file) continue;
      refuseUsage(joined(std::vector{other, option}, " and ") + ": both would write to " + file);
    }
  }
}

// Adds --swept and the rules that tie other options to it.
void addSwept(CommandLine* line, bool* swept) {
  line->addFlag("--swept", swept,
                "The meshes come in twos, a body's earlier and later state; find every contact at "
                "some time between, each vertex moving on a straight line");
  line->requireFor("--times", "--swept");
  line->refuseTogether("--swept", "--margin");
  line->refuseTogether("--swept", "--geometry");
}

// Applies --swept after parsing. First times cost extra work, so they are computed only if --times
// writes them.
void setMotion(bool swept, DetectArguments* arguments) {
  if (!swept) return;
  if (arguments->backend == "fcl") {
    refuseUsage("--swept: backend fcl knows one moment alone; use --backend auto");
  }
  if (arguments->meshes.size() % 2 != 0) {
    refuseUsage("--swept: " + arguments->meshes.back() +
                " has no later state; meshes come in twos, a body's earlier and later state");
  }
  arguments->options.motion = Motion::kSwept;
  arguments->options.first_times = !arguments->times_file.empty();
}

}  // namespace

// Parses first and checks later, because the meaning of some options depends on others. Texts with
// a meaning of their own, such as "auto", go through local variables.
bool parseArguments(int argc, char** argv, DetectArguments* arguments) {
  CommandLine line("detect_contacts", kDescription, kFooter);
  addOptions(&line, arguments);
  bool swept = false;
  addSwept(&line, &swept);
  std::string predicates = "exact", clusters = "auto";
  std::uint64_t memory_limit_mib = arguments->cuda.memory_limit_bytes >> 20;
  line.add("--memory-limit", &memory_limit_mib,
           "Memory for lists of contacts, and of candidates on CUDA, in MiB",
           inRange<std::uint64_t>(1, 1 << 20));
  line.add("--predicates", &predicates, "How sure each verdict is",
           oneOf({"exact", "conservative"}));
  line.add("--clusters", &clusters, "Number of clusters, or auto");
  if (!line.parse(argc, argv)) return false;

  setMotion(swept, arguments);
  Options& options = arguments->options;
  options.predicates = toPredicates(predicates);
  options.clusters = clustersFrom(clusters);
  arguments->cuda.memory_limit_bytes = memory_limit_mib << 20;
  const std::vector<std::string> found = problems(options);
  if (!found.empty()) refuseUsage(joined(found, "; "));
  options.geometry = !arguments->geometry_file.empty();
  options.nearest = !arguments->nearest_file.empty();
  refuseOutputs(*arguments);
  return true;
}

}  // namespace deformable_contact_monitor
