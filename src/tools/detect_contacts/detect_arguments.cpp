// The command line of detect_contacts.
#include "tools/detect_contacts/detect_arguments.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <system_error>

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

void addOptions(CLI::App* app, DetectArguments* arguments) {
  Options& options = arguments->options;
  app->add_option("MESH", arguments->meshes, "Mesh files")->required();
  app->add_flag("--self", arguments->self, "Also find contacts of every body with itself");
  app->add_option("--backend", arguments->backend, "What runs the detection")
      ->check(CLI::IsMember(backendNames()))
      ->capture_default_str();
  app->add_option("--device", arguments->cuda.device, "Of the CUDA devices, which one")
      ->check(CLI::Range(0, 1023))
      ->capture_default_str();
  app->add_option("--overlap", options.overlap,
                  "Share of a triangle that decides its clusters, in [0, 1]; 1 finds every contact")
      ->capture_default_str();
  app->add_option("--margin", arguments->margin_m,
                  "Report triangles at this distance or less, in the meshes' unit")
      ->capture_default_str();
  app->add_option("--repeat", arguments->repeat, "Detect this often, for the times")
      ->check(CLI::Range(1, 1000000000))
      ->capture_default_str();
  app->add_option("--threads", options.threads, "Threads of the cpu backend; 0: all cores")
      ->capture_default_str();
  app->add_option("--fuzzifier", options.fuzzifier, "Of fuzzy c-means, in [1.05, 4]")
      ->capture_default_str();
  app->add_option("--iterations", options.iterations, "Of fuzzy c-means a refresh, in [0, 100]")
      ->capture_default_str();
  app->add_option("--refresh-period", options.refresh_period, "Cycles between refreshes")
      ->capture_default_str();
  app->add_option(
      "--pairs", arguments->pairs_file,
      "Write a line 'bodyA triA bodyB triB' for each contact, sorted, here (-: standard "
      "output)");
  app->add_option("--json", arguments->json_file,
                  "Write counts, options and milliseconds here (-: standard output)");
}

}  // namespace

bool parseArguments(int argc, char** argv, DetectArguments* arguments) {
  CLI::App app(kDescription, "detect_contacts");
  app.footer(kFooter);
  app.set_version_flag("--version", "detect_contacts " DCM_VERSION);
  addOptions(&app, arguments);
  std::string predicates = "exact", clusters = "auto";
  std::uint64_t memory_limit_mib = arguments->cuda.memory_limit_bytes >> 20;
  app.add_option("--memory-limit", memory_limit_mib,
                 "Memory for lists of contacts, and of candidates on CUDA, in MiB")
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  addAdjacent(&app, &arguments->options.adjacent);
  app.add_option("--predicates", predicates, "How sure each verdict is")
      ->check(CLI::IsMember({"exact", "conservative", "fast"}))
      ->capture_default_str();
  app.add_option("--clusters", clusters, "Number of clusters, or auto")->capture_default_str();
  if (!parsed(&app, argc, argv)) return false;

  Options& options = arguments->options;
  options.predicates = toPredicates(predicates);
  options.clusters = clustersFrom(clusters);
  arguments->cuda.memory_limit_bytes = memory_limit_mib << 20;
  std::string found;
  for (const std::string& problem : problems(options)) {
    found += (found.empty() ? "" : "; ") + problem;
  }
  if (!found.empty()) refuseUsage(found);
  refuseMeshAsOutput("--pairs", arguments->pairs_file);
  refuseMeshAsOutput("--json", arguments->json_file);
  if (!arguments->pairs_file.empty() && arguments->pairs_file == arguments->json_file) {
    refuseUsage("--pairs and --json: both would write to " + arguments->json_file);
  }
  return true;
}

}  // namespace deformable_contact_monitor
