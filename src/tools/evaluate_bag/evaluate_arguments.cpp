// The command line of evaluate_bag.
#include "tools/evaluate_bag/evaluate_arguments.h"

#include "robot/urdf_document.h"
#include "tools/common/backend_choice.h"
#include "tools/common/command_line.h"

namespace deformable_contact_monitor {
namespace {

// The texts of --help before and after the list of options.
constexpr const char* kDescription =
    "Finds the contacts of every deformable mesh in ROS bags, at the mesh's own stamp, by the "
    "rules "
    "of the node contact_monitor, and without missing a mesh. Needs no ROS master. Writes "
    "frames.csv, links.csv, events.csv, distances.csv, summary.json and report.html. One process "
    "evaluates one "
    "recording; evaluate_bags runs many of them side by side.";
constexpr const char* kFooter =
    "Exit code: 0: passed; 1: the cpu and cuda backends disagree, or an expectation fails; 2: bad "
    "input, a damaged bag (what could be read is evaluated), or no cycle could be evaluated. With "
    "2, one line on standard error says why.";

}  // namespace

// The options of a played object are shared with soft_scene.
bool parseArguments(int argc, char** argv, EvaluateArguments* arguments) {
  CommandLine line("evaluate_bag", kDescription, kFooter);
  line.addPositionals("BAG", &arguments->files.bags, true, "Bags, read as one recording");
  describe(&line, &arguments->files);
  line.add("--expect", &arguments->expectations, "Which bodies must touch, and when (yaml)");
  line.add("--out", &arguments->out, "Folder to write to");
  line.addList("--backends", &arguments->backends,
               "Backends to run and to compare as sets of pairs; each", oneOf(backendNames()));
  line.addList("--predicates", &arguments->predicates, "Predicates to run with each backend; each",
               oneOf({"exact", "conservative"}));
  line.addList("--overlaps", &arguments->overlaps, "Overlaps to run with each backend; each",
               inRange(0.0F, 1.0F));
  line.add("--threads", &arguments->threads,
           "Threads of the cpu backend, instead of the configuration's; 0: all cores",
           inRange(0, 1024));
  line.add("--geometry", &arguments->geometry,
           "Elements of the URDF whose meshes are used, instead of the configuration's geometry",
           oneOf({kGeometryKinds.begin(), kGeometryKinds.end()}));
  line.addFlag("--pairs", &arguments->pairs, "Also write every triangle pair to pairs.csv");
  bool without_report = false;
  line.addFlag("--no-report", &without_report, "Do not draw report.html");
  describe(&line, &arguments->object);
  if (!line.parse(argc, argv)) return false;
  arguments->report = !without_report;
  return true;
}

}  // namespace deformable_contact_monitor
