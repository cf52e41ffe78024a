// Checks a robot, from whatever source, before it is monitored, and describes its links.
#include "monitor/diagnostics/robot_checks.h"

#include <algorithm>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "robot/nearest_name.h"

namespace deformable_contact_monitor {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::string namesOfNoLink(const std::vector<std::string>& names, const RobotGeometry& robot) {
  std::vector<std::string> links;
  for (const LinkGeometry& link : robot.links) links.push_back(link.link);
  std::string missing;
  for (const std::string& name : names) {
    if (contains(links, name)) continue;
    missing += (missing.empty() ? "'" : ", '") + name + "'" + nearestNameHint(name, links);
  }
  return missing;
}

RobotGeometry selectedLinks(RobotGeometry robot, const RobotGeometryOptions& options) {
  std::set<std::string> sent;
  for (const LinkGeometry& link : robot.links) {
    if (!sent.insert(link.link).second) {
      throw std::runtime_error("link '" + link.link + "' was sent twice in one message");
    }
  }
  robot.link_names = sent;
  const std::string missing = namesOfNoLink(options.links, robot);
  if (!missing.empty()) throw std::runtime_error("~links: " + missing + ": no such link was sent");
  const auto unwanted = [&options](const LinkGeometry& link) {
    return (!options.links.empty() && !contains(options.links, link.link)) ||
           contains(options.ignored_links, link.link);
  };
  robot.links.erase(std::remove_if(robot.links.begin(), robot.links.end(), unwanted),
                    robot.links.end());
  return robot;
}

void checkRobot(const RobotGeometry& robot, const MonitorParameters& parameters) {
  std::string bad;
  for (const LinkGeometry& link : robot.links) {
    for (const ObjectParameters& object : parameters.objects) {
      if (link.link == object.name) {
        throw std::runtime_error("'" + object.name +
                                 "' is the name of a link and of an object; rename the object");
      }
      for (const PartParameters& part : object.parts) {
        if (link.link != object.name + ":" + part.name) continue;
        throw std::runtime_error("'" + link.link +
                                 "' is the name of a link and of a part of an object; rename the "
                                 "part");
      }
    }
    if (!link.problem.empty()) bad += "\n  " + link.problem;
  }
  if (parameters.strict_geometry && !bad.empty()) {
    throw std::runtime_error("strict_geometry is on, but these links have no usable geometry:" +
                             bad);
  }
}

std::vector<std::string> robotWarnings(const RobotGeometry& robot,
                                       const MonitorParameters& parameters) {
  std::vector<std::string> warnings;
  for (const LinkGeometry& link : robot.links) {
    if (!link.problem.empty()) warnings.push_back(describeLink(link, parameters));
  }
  const auto add = [&warnings](const std::vector<std::string>& lines) {
    warnings.insert(warnings.end(), lines.begin(), lines.end());
  };
  add(geometryWarnings(robot));
  if (!(robot.srdf == Srdf())) add(srdfWarnings(robot.srdf, robot.name, robot.link_names));
  return warnings;
}

std::string ignoredLinksWarning(const RobotGeometry& sent, const RobotGeometryOptions& options) {
  const std::string missing = namesOfNoLink(options.ignored_links, sent);
  return missing.empty() ? "" : "~ignored_links: " + missing + ": no such link was sent";
}

std::string describeLink(const LinkGeometry& link, const MonitorParameters& parameters) {
  if (!link.problem.empty()) return link.problem + "; the link is UNKNOWN";
  std::ostringstream text;
  text << "link '" << link.link << "': " << link.mesh.triangleCount() << " triangles, "
       << linkLengthM(link) << " m long, margin " << linkMarginM(parameters, link.link)
       << " m, from " << link.source;
  return text.str();
}

}  // namespace deformable_contact_monitor
