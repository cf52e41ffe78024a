// The command line of evaluate_bag.
#include "tools/evaluate_bag/evaluate_arguments.h"

#include <CLI/CLI.hpp>

#include "tools/common/backend_choice.h"
#include "tools/common/command_line.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kDescription =
    "Finds the contacts of every deformable mesh in ROS bags, at the mesh's own stamp, as the node "
    "contact_monitor would if it never missed one. Needs no ROS master. Writes frames.csv, "
    "links.csv, summary.json and report.html.";
constexpr const char* kFooter =
    "Exit code: 0; 1 if the cpu and cuda backends disagree or an expectation fails; 2 with one "
    "line "
    "on standard error on bad input (what could be read of a damaged bag is evaluated all the "
    "same).";

}  // namespace

bool parseArguments(int argc, char** argv, EvaluateArguments* arguments) {
  CLI::App app(kDescription, "evaluate_bag");
  app.footer(kFooter);
  app.set_version_flag("--version", "evaluate_bag " DCM_VERSION);
  app.add_option("BAG", arguments->files.bags, "Bags, read as one")->required();
  app.add_option(
      "--config", arguments->files.config,
      "Parameters of contact_monitor, yaml; without it every deformable mesh topic is an "
      "object, and the rest are defaults");
  app.add_option("--expect", arguments->expectations, "Who must touch whom and when, yaml");
  app.add_option("--robot-description", arguments->files.robot_description,
                 "URDF, or a rosparam dump of it; else the bags' link meshes or robot_description");
  app.add_option("--reference-frame", arguments->files.reference_frame,
                 "Frame of the contacts, instead of the configuration's");
  app.add_option("--out", arguments->out, "Folder to write to")->capture_default_str();
  app.add_option("--backends", arguments->backends, "Compared as sets: cpu,cuda,fcl,brute_force")
      ->delimiter(',')
      ->check(CLI::IsMember(backendNames()));
  app.add_option("--predicates", arguments->predicates, "exact,conservative,fast")
      ->delimiter(',')
      ->check(CLI::IsMember({"exact", "conservative", "fast"}));
  app.add_option("--overlaps", arguments->overlaps, "Values of overlap, each in [0, 1]")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 1.0));
  app.add_flag("--pairs", arguments->pairs, "Also write every triangle pair to pairs.csv");
  app.add_flag("!--no-report", arguments->report, "Draw no report.html");
  describe(&app, &arguments->object);
  return parsed(&app, argc, argv);
}

}  // namespace deformable_contact_monitor
