// Describes the start of the node for people who see its console for the first time.
#include "monitor/diagnostics/start_block.h"

#include <algorithm>
#include <cstddef>
#include <sstream>

#include "monitor/input/mesh_subscription.h"
#include "monitor/input/transform_lookup.h"

namespace deformable_contact_monitor {
namespace {

// Appends a line to the block: the word that says what it is about, in a column of its own.
void add(const std::string& about, const std::string& text, std::string* block) {
  constexpr std::size_t kColumn = 9;
  *block += "\n  " + about + std::string(kColumn - about.size(), ' ') + text;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// Returns "1 link" or "2 links".
std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

// Returns "0.1 m", or "0.1 to 0.3 m" where they differ; zero if there are none.
std::string range(const std::vector<double>& values_m) {
  const auto [least, most] = std::minmax_element(values_m.begin(), values_m.end());
  std::ostringstream text;
  if (values_m.empty()) return "0 m";
  text << *least;
  if (*most > *least) text << " to " << *most;
  text << " m";
  return text.str();
}

// The length of the longest link shows whether a mesh file is in millimetres.
std::string describeRobot(const DescribedRobot& robot, const RobotGeometry& all) {
  std::size_t links = 0, broken = 0, triangles = 0;
  const LinkGeometry* longest = nullptr;
  for (const LinkGeometry& link : all.links) {
    if (robot.links.count(link.link) == 0) continue;
    if (!link.problem.empty()) ++broken;
    if (!link.problem.empty()) continue;
    ++links;
    triangles += link.mesh.triangleCount();
    if (longest == nullptr || linkLengthM(link) > linkLengthM(*longest)) longest = &link;
  }
  std::ostringstream text;
  if (!robot.name.empty()) text << "'" << robot.name << "': ";
  text << counted(links, "link") << " with " << counted(triangles, "triangle");
  if (longest != nullptr) {
    text << ", the longest is '" << longest->link << "' with " << linkLengthM(*longest) << " m";
  }
  if (broken > 0) text << "; " << counted(broken, "link") << " UNKNOWN without a usable mesh";
  const std::size_t pairs = robot.srdf.disabled.size();
  if (pairs > 0) text << "; its SRDF lets " << counted(pairs, "pair") << " of links touch";
  return text.str();
}

void addObjects(const MonitorParameters& parameters, const std::vector<std::string>& topics,
                std::string* block) {
  for (std::size_t i = 0; i < parameters.objects.size(); ++i) {
    const ObjectParameters& object = parameters.objects[i];
    std::string text = "'" + object.name + "': " + messageType(object.type) + " on " + topics.at(i);
    if (!object.parts.empty()) text += ", " + counted(object.parts.size(), "part");
    add("object", text, block);
  }
  for (const RigidParameters& rigid : parameters.rigids) {
    add("object", "'" + rigid.name + "': rigid, in TF frame '" + rigid.frame + "'", block);
  }
  if (parameters.objects.empty() && parameters.rigids.empty()) {
    add("object", "none", block);
  }
}

std::string describeMargins(const MonitorParameters& parameters, const RobotGeometry* robot) {
  std::vector<double> links, objects;
  if (robot != nullptr) {
    for (const LinkGeometry& link : robot->links) {
      links.push_back(linkMarginM(parameters, link.link));
    }
  } else if (parameters.pair_classes.needRobot()) {  // of links that are not there yet
    links.push_back(parameters.margin_m);
    for (const auto& [link, margin_m] : parameters.link_margin_m) links.push_back(margin_m);
  }
  for (const ObjectParameters& object : parameters.objects) {
    objects.push_back(object.margin_m);
    for (const PartParameters& part : object.parts) {
      if (part.margin_m) objects.push_back(*part.margin_m);
    }
  }
  for (const RigidParameters& rigid : parameters.rigids) objects.push_back(rigid.margin_m);
  std::string text;
  if (!links.empty()) text = "links " + range(links);
  if (!objects.empty()) text += (text.empty() ? "objects " : ", objects ") + range(objects);
  const auto is_zero = [](double margin_m) { return margin_m == 0; };
  if (std::all_of(links.begin(), links.end(), is_zero) &&
      std::all_of(objects.begin(), objects.end(), is_zero)) {
    text +=
        std::string(text.empty() ? "" : ": ") + "no distances, only what touches (set margin_m)";
  }
  return text;
}

std::string describeBackend(const MonitorParameters& parameters, const StartFacts& facts) {
  if (facts.backend != "cpu") return "CUDA";
  if (parameters.backend == BackendChoice::kCpu) return "CPU, as asked for";
  return "CPU" + (facts.backend_problem.empty() ? "" : ", not CUDA: " + facts.backend_problem);
}

// Returns whether other lines of the block say what a changed parameter is.
bool isShown(const std::string& changed) {
  const std::string name = changed.substr(0, changed.find(':'));
  return name == "reference_frame" || name == "objects" || name == "pair_classes";
}

}  // namespace

std::string describeRobots(const RobotGeometry& robot) {
  std::string lines;
  for (const DescribedRobot& one : robot.robots) add("robot", describeRobot(one, robot), &lines);
  return lines;
}

std::string describeStart(const MonitorParameters& parameters, const StartFacts& facts) {
  std::string block = "looks for contacts in frame '" + parameters.reference_frame + "':";
  if (facts.robot != nullptr) {
    block += describeRobots(*facts.robot);
  } else {
    const bool is_needed = parameters.pair_classes.needRobot();
    add("robot", is_needed ? "not there yet" : "none is watched", &block);
  }
  addObjects(parameters, facts.topics, &block);
  add("pairs", joined(namesOf(parameters.pair_classes)), &block);
  add("margins", describeMargins(parameters, facts.robot), &block);
  add("backend", describeBackend(parameters, facts), &block);
  for (const std::string& value : parameters.changed) {
    if (!isShown(value)) add("set", value, &block);
  }
  for (const std::string& line : facts.missing) add("missing", line, &block);
  if (facts.missing.empty()) add("missing", "nothing", &block);
  add("see", "config/docs/console.md#at-the-start", &block);
  return block;
}

std::vector<std::string> missingTransforms(const MonitorParameters& parameters,
                                           const RobotGeometry* robot,
                                           const TransformBuffer& transforms) {
  std::vector<std::string> lines;
  const auto look = [&](const std::vector<FrameAtStamp>& frames, const std::string& what) {
    std::size_t count = 0;
    std::string first;
    for (const PoseAnswer& answer :
         TransformLookup(transforms, parameters.reference_frame).lookup(frames)) {
      if (answer.outcome == PoseAnswer::Outcome::kFound) continue;
      if (count++ == 0) first = answer.problem;
    }
    if (count == 0) return;
    lines.push_back("TF of " + std::to_string(count) + " of " + counted(frames.size(), what) +
                    ": " + first);
  };
  std::vector<FrameAtStamp> links, rigids;
  if (robot != nullptr) {
    for (const LinkGeometry& link : robot->links) {
      links.push_back({parameters.frameOf(link.link), ros::Time(), link.link});
    }
  }
  for (const RigidParameters& rigid : parameters.rigids) {
    rigids.push_back({rigid.frame, ros::Time(), rigid.name});
  }
  look(links, "link");
  look(rigids, "rigid object");
  return lines;
}

}  // namespace deformable_contact_monitor
