// The command line of evaluate_bag.
#include "tools/evaluate_bag/evaluate_arguments.h"

#include <algorithm>
#include <charconv>

#include "tools/common/backend_choice.h"
#include "tools/common/command_line.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint64_t kMostParts = 100000;
constexpr const char* kDescription =
    "Finds the contacts of every deformable mesh in ROS bags, at the mesh's own stamp, as the node "
    "contact_monitor would if it never missed one. Needs no ROS master. Writes frames.csv, "
    "links.csv, summary.json and report.html.";
constexpr const char* kFooter =
    "Exit code: 0; 1 if the cpu and cuda backends disagree or an expectation fails; 2 with one "
    "line on standard error on bad input (what could be read of a damaged bag is evaluated all the "
    "same), or if no cycle could be evaluated.";

// "K/N".
BagPart partOf(const std::string& text) {
  BagPart part;
  const std::size_t slash = std::min(text.find('/'), text.size());
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), text.data() + slash, part.number);
  const auto of = std::from_chars(std::min(text.data() + slash + 1, end), end, part.of);
  if (number.ec != std::errc() || of.ec != std::errc() || number.ptr != text.data() + slash ||
      of.ptr != end || part.number < 1 || part.of < part.number || part.of > kMostParts) {
    refuseUsage("--part: " + text +
                " is not K/N with 1 <= K <= N <= " + std::to_string(kMostParts));
  }
  return part;
}

}  // namespace

bool parseArguments(int argc, char** argv, EvaluateArguments* arguments) {
  CommandLine line("evaluate_bag", kDescription, kFooter);
  line.addPositionals("BAG", &arguments->files.bags, true, "Bags, read as one");
  line.add("--config", &arguments->files.config,
           "Parameters of contact_monitor, yaml; without it every deformable mesh topic is an "
           "object, and the rest are defaults");
  line.add("--expect", &arguments->expectations, "Who must touch whom and when, yaml");
  line.add("--robot-description", &arguments->files.robot_description,
           "URDF, or a rosparam dump of it; else the bags' link meshes or robot_description");
  line.add("--srdf", &arguments->files.srdf,
           "SRDF, whose disabled pairs of links may touch, or none; else the configuration's srdf, "
           "where auto is the bags' robot_description_semantic");
  line.add("--reference-frame", &arguments->files.reference_frame,
           "Frame of the contacts, instead of the configuration's");
  line.add("--out", &arguments->out, "Folder to write to");
  line.addList("--backends", &arguments->backends, "Compared as sets; each", oneOf(backendNames()));
  line.addList("--predicates", &arguments->predicates, "Each",
               oneOf({"exact", "conservative", "fast"}));
  line.addList("--overlaps", &arguments->overlaps, "Each", inRange(0.0F, 1.0F));
  line.add("--threads", &arguments->threads,
           "Threads of the cpu backend, instead of the configuration's; 0: all cores",
           inRange(0, 1024));
  line.addFlag("--pairs", &arguments->pairs, "Also write every triangle pair to pairs.csv");
  bool without_report = false;
  line.addFlag("--no-report", &without_report, "Draw no report.html");
  std::string part;
  line.add("--part", &part,
           "K/N: of N parts of the bags' cycles, each with about as many meshes, find the contacts "
           "of part K alone, and write them to --records");
  line.add("--records", &arguments->records, "File to write");
  line.requireFor("--part", "--records");
  line.requireFor("--records", "--part");
  line.addWords("--join", &arguments->joined,
                "Records of all parts, made with the other options as they are here: evaluate "
                "these, and detect nothing");
  line.refuseTogether("--part", "--join");
  describe(&line, &arguments->object);
  if (!line.parse(argc, argv)) return false;
  if (!part.empty()) arguments->part = partOf(part);
  arguments->report = !without_report;
  return true;
}

}  // namespace deformable_contact_monitor
