// Checks a robot, from whatever source, before it is monitored, and describes its links.
#include "monitor/diagnostics/robot_checks.h"

#include <algorithm>
#include <boost/algorithm/cxx11/any_of.hpp>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "monitor/cycle_report.h"
#include "robot/nearest_name.h"

namespace deformable_contact_monitor {
namespace {

constexpr char kRejected[] = "the newest link meshes are rejected: ";

}  // namespace

std::string namesOfNoLink(const std::vector<std::string>& names, const RobotGeometry& robot) {
  std::vector<std::string> links;
  for (const LinkGeometry& link : robot.links) links.push_back(link.link);
  std::string missing;
  for (const std::string& name : names) {
    if (boost::algorithm::any_of_equal(links, name)) continue;
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
    return (!options.links.empty() && !boost::algorithm::any_of_equal(options.links, link.link)) ||
           boost::algorithm::any_of_equal(options.ignored_links, link.link);
  };
  robot.links.erase(std::remove_if(robot.links.begin(), robot.links.end(), unwanted),
                    robot.links.end());
  return robot;
}

RobotGeometry withoutShapes(RobotGeometry robot, const std::string& problem) {
  for (LinkGeometry& link : robot.links) {
    link.problem = std::string(kRejected) + problem;
    link.mesh = TriangleMesh();
  }
  return robot;
}

bool isWithoutShapes(const RobotGeometry& robot) {
  return !robot.links.empty() && robot.links.front().problem.rfind(kRejected, 0) == 0;
}

// A proper prefix of a text is less than the text, so of the prefixes of a name, the longest comes
// first. Where robots share a prefix nobody knows whose a link is, so what an SRDF says about all
// pairs of a link is dropped: more pairs are monitored then, never fewer.
void setSrdfs(const std::vector<RobotParameters>& parameters, const std::vector<Srdf>& srdfs,
              RobotGeometry* robot) {
  std::map<std::string, DescribedRobot, std::greater<>> by_prefix;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    Srdf srdf = prefixed(srdfs[i], parameters[i].link_prefix, robot->link_names);
    const auto [place, is_new] = by_prefix.emplace(parameters[i].link_prefix, DescribedRobot());
    Srdf& all = place->second.srdf;
    if (is_new) {
      all = std::move(srdf);
      continue;
    }
    all.disabled.insert(all.disabled.end(), srdf.disabled.begin(), srdf.disabled.end());
    all.enabled.insert(all.enabled.end(), srdf.enabled.begin(), srdf.enabled.end());
    all.disabled_links.clear();
  }
  for (const std::string& link : robot->link_names) {
    const auto owns = [&link](const auto& entry) {
      return link.compare(0, entry.first.size(), entry.first) == 0;
    };
    const auto owner = std::find_if(by_prefix.begin(), by_prefix.end(), owns);
    if (owner != by_prefix.end()) owner->second.links.insert(link);
  }
  robot->robots.clear();
  for (auto& [prefix, one] : by_prefix) robot->robots.push_back(std::move(one));
}

void checkRobot(const RobotGeometry& robot, const MonitorParameters& parameters) {
  std::string bad;
  for (const LinkGeometry& link : robot.links) {
    if (link.link.empty()) throw std::runtime_error("a link has no name");
    for (const ObjectParameters& object : parameters.objects) {
      if (link.link == object.name) {
        throw std::runtime_error("'" + object.name +
                                 "' is the name of a link and of an object; rename the object");
      }
      if (link.link == object.name + ":" + kHeldPart) {
        throw std::runtime_error("'" + link.link + "' is the name of a link and of the part of '" +
                                 object.name + "' that ~attach_object makes; rename the object");
      }
      for (const PartParameters& part : object.parts) {
        if (link.link != object.name + ":" + part.name) continue;
        throw std::runtime_error("'" + link.link +
                                 "' is the name of a link and of a part of an object; rename the "
                                 "part");
      }
    }
    for (const RigidParameters& rigid : parameters.rigids) {
      if (link.link != rigid.name) continue;
      throw std::runtime_error("'" + rigid.name +
                               "' is the name of a link and of a rigid object; rename the object");
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
  for (const RobotParameters& one : parameters.robots) {
    const auto is_of_one = [&one](const std::string& link) {
      return link.compare(0, one.link_prefix.size(), one.link_prefix) == 0;
    };
    if (std::any_of(robot.link_names.begin(), robot.link_names.end(), is_of_one)) continue;
    warnings.push_back("~robots: no link has the prefix '" + one.link_prefix +
                       "'; one LinkMeshes must have the links of all robots");
  }
  for (const DescribedRobot& one : robot.robots) {
    std::set<std::string> names = one.links;
    for (const RigidParameters& rigid : parameters.rigids) names.insert(rigid.name);
    if (!(one.srdf == Srdf())) add(srdfWarnings(one.srdf, one.name, names));
  }
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
