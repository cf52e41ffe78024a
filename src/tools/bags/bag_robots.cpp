// Loads the robots of recorded cycles. As in the node, a URDF that cannot be used leaves the robot
// as it was, and link meshes that cannot be used leave its links without shapes.
#include "tools/bags/bag_robots.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "monitor/diagnostics/robot_checks.h"
#include "monitor/messages/contact_messages.h"
#include "tools/common/yaml_parameters.h"

namespace deformable_contact_monitor {
namespace {

using Warn = std::function<void(const std::string&)>;
using Descriptions = std::vector<RobotDescription>;

using Rejections = History<std::string>;  // what is wrong with values that cannot be used

// Makes a robot from each recorded value. Throws what the last one throws if none can be used.
template <typename T>
History<RobotGeometry> robotsOf(const History<T>& values, const MonitorParameters& parameters,
                                const std::function<RobotGeometry(const T&)>& make,
                                Rejections* rejections) {
  History<RobotGeometry> robots;
  for (const Recorded<T>& recorded : values) {
    try {
      RobotGeometry robot = make(recorded.value);
      checkRobot(robot, parameters);
      robots.push_back({recorded.received, std::move(robot)});
    } catch (const std::exception& error) {
      if (&recorded == &values.back() && robots.empty()) throw;
      rejections->push_back({recorded.received, error.what()});
    }
  }
  return robots;
}

// Adds a robot without shapes where the first message is rejected after one that was not, with the
// links of the robot before it, or of the first one.
History<RobotGeometry> withRejections(const History<RobotGeometry>& robots,
                                      const Rejections& rejections) {
  History<RobotGeometry> all = robots;
  const auto later = [&robots](const ros::Time& time) {  // robots that came later
    return std::count_if(robots.begin(), robots.end(),
                         [&time](const auto& robot) { return time < robot.received; });
  };
  for (std::size_t i = 0; i < rejections.size(); ++i) {
    const ros::Time& time = rejections[i].received;
    if (i > 0 && later(rejections[i - 1].received) == later(time)) continue;
    all.push_back({time, withoutShapes(robots[indexAt(robots, time)].value, rejections[i].value)});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.received < b.received; });
  return all;
}

// Returns the URDFs of one robot; none if nothing was recorded.
History<std::string> urdfsOf(const BagFiles& files, const BagContents& contents,
                             std::size_t robot) {
  if (!files.robot_description.empty()) {
    return {{ros::Time(), readRobotDescription(files.robot_description)}};
  }
  const auto found = contents.robot_descriptions.find(contents.chosen.robots[robot].description);
  return found == contents.robot_descriptions.end() ? History<std::string>() : found->second;
}

bool same(const Descriptions& a, const Descriptions& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.urdf_xml == other.urdf_xml;
  });
}

// Returns the descriptions of all robots, anew at each time when one of them was recorded with a
// change.
History<Descriptions> descriptionsOf(const BagFiles& files, const BagContents& contents,
                                     const MonitorParameters& parameters,
                                     const std::vector<Srdf>& srdfs) {
  const std::vector<RobotParameters> robots = parameters.allRobots();
  const bool is_list = !parameters.robots.empty();
  std::vector<History<std::string>> urdfs;
  std::set<ros::Time> times;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    urdfs.push_back(urdfsOf(files, contents, i));
    if (urdfs.back().empty()) {
      throw std::runtime_error("no robot: the bags hold neither link meshes nor a " +
                               (is_list ? "URDF on " + absoluteTopic(robots[i].description)
                                        : "robot_description; give --robot-description FILE"));
    }
    for (const Recorded<std::string>& urdf : urdfs.back()) times.insert(urdf.received);
  }
  History<Descriptions> history;
  for (const ros::Time& time : times) {
    Descriptions all;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const std::string source = !files.robot_description.empty() ? files.robot_description
                                 : is_list ? contents.chosen.robots[i].description
                                           : "the bags' robot_description";
      all.push_back(
          {urdfs[i][indexAt(urdfs[i], time)].value, source, robots[i].link_prefix, srdfs[i]});
    }
    if (history.empty() || !same(history.back().value, all)) history.push_back({time, all});
  }
  return history;
}

// Loads one robot's SRDF. Its rules are about pairs of links, which no cycle of a mesh looks at, so
// it needs no history.
Srdf loadSrdf(const std::string& named, const std::string& topic, const BagContents& contents,
              const Warn& warn) {
  const auto recorded = contents.robot_semantics.find(topic);
  if (named == kSrdfNone) return {};
  if (named == kSrdfAuto && recorded == contents.robot_semantics.end()) return {};
  try {
    if (named == kSrdfAuto) return readSrdf(recorded->second);
    return readSrdfFile(named.find("://") == std::string::npos ? named : makeRosResolver()(named));
  } catch (const std::exception& error) {
    if (named != kSrdfAuto) throw std::runtime_error(error.what());
    warn("the bags' robot_description_semantic is not used: " + std::string(error.what()));
    return {};
  }
}

}  // namespace

History<RobotGeometry> loadBagRobots(const BagFiles& files, const MonitorParameters& parameters,
                                     const BagContents& contents, std::string* from,
                                     const Warn& warn) {
  const std::vector<RobotParameters> described = parameters.allRobots();
  std::vector<Srdf> srdfs;
  for (std::size_t i = 0; i < described.size(); ++i) {
    srdfs.push_back(loadSrdf(files.srdf.empty() ? described[i].srdf : files.srdf,
                             contents.chosen.robots[i].semantic, contents, warn));
  }
  Rejections rejections;
  if (!contents.link_meshes.empty()) {
    *from = "the bags' link meshes";
    const History<RobotGeometry> robots = robotsOf<RecordedLinkMeshes>(
        contents.link_meshes, parameters,
        [&](const RecordedLinkMeshes& recorded) {
          if (!recorded.problem.empty()) throw std::runtime_error(recorded.problem);
          const RobotGeometry sent = fromLinkMeshes(recorded.message);
          const std::string ignored = ignoredLinksWarning(sent, parameters.geometry);
          if (!ignored.empty()) warn(ignored);
          RobotGeometry robot = selectedLinks(sent, parameters.geometry);
          setSrdfs(described, srdfs, &robot);
          return robot;
        },
        &rejections);
    for (const Recorded<std::string>& one : rejections) {
      warn("the link meshes that were recorded at " + stampText(one.received) +
           " are rejected, so every link is UNKNOWN until the next ones: " + one.value);
    }
    return withRejections(robots, rejections);
  }
  *from = files.robot_description.empty() ? "the bags' robot_description" : files.robot_description;
  History<RobotGeometry> robots = robotsOf<Descriptions>(
      descriptionsOf(files, contents, parameters, srdfs), parameters,
      [&](const Descriptions& robots) {
        try {
          return loadRobots(robots, parameters.geometry, makeRosResolver());
        } catch (const std::invalid_argument& error) {
          throw std::runtime_error(error.what());
        }
      },
      &rejections);
  for (const Recorded<std::string>& one : rejections) {
    warn("the robot that was recorded at " + stampText(one.received) +
         " is not used: " + one.value);
  }
  return robots;
}

std::size_t firstWithShapes(const History<RobotGeometry>& robots) {
  const auto first = std::find_if(robots.begin(), robots.end(),
                                  [](const auto& robot) { return !isWithoutShapes(robot.value); });
  return first == robots.end() ? 0 : static_cast<std::size_t>(first - robots.begin());
}

// TF has priority: only frames that it does not have are added.
void useJointStates(const BagFiles& files, const MonitorParameters& parameters,
                    BagContents* contents, const Warn& warn) {
  if (!parameters.robots.empty()) return;
  const History<std::string> urdfs = urdfsOf(files, *contents, 0);
  if (urdfs.empty()) return;
  try {
    contents->addJointTransforms(urdfs, parameters.frame_prefix);
  } catch (const std::exception& error) {
    warn("the URDF poses no links by " + contents->chosen.joint_states + ": " + error.what());
  }
}

}  // namespace deformable_contact_monitor
