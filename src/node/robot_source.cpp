// Provides the robots' link meshes, from robot_description or from a topic.
#include "node/robot_source.h"

#include <ros/console.h>
#include <ros/init.h>
#include <ros/param.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "monitor/diagnostics/robot_checks.h"
#include "monitor/input/checked_subscription.h"
#include "monitor/messages/contact_messages.h"

namespace deformable_contact_monitor {
namespace {

// Compares bytes, so that a vertex that is not a number equals itself.
bool same(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices.size() == b.vertices.size() && a.triangles == b.triangles &&
         (a.vertices.empty() || std::memcmp(a.vertices.data(), b.vertices.data(),
                                            a.vertices.size() * sizeof(float)) == 0);
}

// Compares all that detection depends on. A robot that is sent again must not start a new scene.
bool same(const RobotGeometry& a, const RobotGeometry& b) {
  return a.robots == b.robots && a.unmonitored_links == b.unmonitored_links &&
         a.joints == b.joints &&
         std::equal(a.links.begin(), a.links.end(), b.links.begin(), b.links.end(),
                    [](const LinkGeometry& l, const LinkGeometry& m) {
                      return l.link == m.link && l.problem == m.problem && same(l.mesh, m.mesh);
                    });
}

// Logs what is suspicious about the robot and its SRDF, and for those who look for it each link.
void log(const RobotGeometry& robot, const MonitorParameters& parameters) {
  for (const LinkGeometry& link : robot.links) {
    if (link.problem.empty()) ROS_DEBUG_STREAM(describeLink(link, parameters));
  }
  for (const std::string& line : robotWarnings(robot, parameters)) {
    ROS_WARN_STREAM(line << "; see config/docs/console.md#the-robot");
  }
}

// Returns the name of a robot's `srdf`: "~srdf", or the robot's entry among several.
std::string srdfOf(const RobotParameters& robot, const MonitorParameters& parameters) {
  if (parameters.robots.empty()) return "~srdf";
  return "~robots: srdf of '" + robot.description + "' with frame_prefix '" + robot.link_prefix +
         "':";
}

}  // namespace

RobotSource::RobotSource(const MonitorParameters& parameters, const ros::NodeHandle& node,
                         ros::NodeHandle private_node, std::function<void()> changed)
    : parameters_(parameters), node_(node), changed_(std::move(changed)) {
  if (!parameters_.pair_classes.needRobot()) return;
  loadFirstSrdfs();
  if (parameters_.robot_source == RobotSourceKind::kUrdf) {
    use(loadFromDescriptions(srdfs_));
  } else {
    ros::SubscribeOptions options = checkedSubscription<LinkMeshes>(
        "robot_link_meshes", 1, [this](const LinkMeshes::ConstPtr& message) { receive(message); },
        [this](const std::string& problem) { reject(problem); });
    subscriber_ = private_node.subscribe(options);
  }
}

void RobotSource::reload() {
  if (!parameters_.pair_classes.needRobot()) throw std::runtime_error("no robot is monitored");
  if (parameters_.robot_source == RobotSourceKind::kTopic) {
    throw std::runtime_error("the robot comes from ~robot_link_meshes: publish it again");
  }
  std::vector<Srdf> srdfs;
  for (const RobotParameters& robot : parameters_.allRobots()) srdfs.push_back(loadSrdf(robot));
  if (use(loadFromDescriptions(srdfs))) changed_();
  const std::lock_guard<std::mutex> lock(mutex_);
  srdf_problem_.clear();
}

// Returns "/" for the root. A nodelet's handle calls it "", from where ros::param::search() finds
// nothing.
std::string RobotSource::searchNamespace() const {
  return node_.getNamespace().empty() ? "/" : node_.getNamespace();
}

// Returns an SRDF without rules if there is none to read.
Srdf RobotSource::loadSrdf(const RobotParameters& robot) const {
  if (robot.srdf == kSrdfNone) return {};
  if (robot.srdf != kSrdfAuto) {
    try {
      return readSrdfFile(makeRosResolver()(robot.srdf));
    } catch (const std::exception& error) {
      throw std::runtime_error(srdfOf(robot, parameters_) + " '" + robot.srdf +
                               "': " + error.what());
    }
  }
  const std::string name = robot.description + "_semantic";
  std::string found, xml;
  if (!ros::param::search(searchNamespace(), name, found) || !ros::param::has(found)) return {};
  if (!node_.getParam(found, xml)) {
    throw std::runtime_error("parameter '" + found + "' is not a text; set " +
                             srdfOf(robot, parameters_) + " to none to ignore it");
  }
  try {
    return readSrdf(xml);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("parameter '" + found + "': " + error.what());
  }
}

// A user who names a file relies on it, so the node does not start without it. A parameter that
// happens to exist is different: without its rules, more pairs are monitored, never fewer.
void RobotSource::loadFirstSrdfs() {
  for (const RobotParameters& robot : parameters_.allRobots()) {
    srdfs_.emplace_back();
    try {
      srdfs_.back() = loadSrdf(robot);
    } catch (const std::runtime_error& error) {
      if (robot.srdf != kSrdfAuto) throw;
      ROS_ERROR_STREAM("the SRDF is not used, so its rules allow no contacts: "
                       << error.what() << "; see config/README.md#what-may-touch");
      srdf_problem_ += (srdf_problem_.empty() ? "" : "; ") + std::string(error.what());
    }
  }
}

// Searches for the parameter upwards from the node's namespace, as other ROS nodes do.
RobotDescription RobotSource::readDescription(const RobotParameters& robot) const {
  RobotDescription description;
  std::string found;
  const std::string from = searchNamespace();
  if (!ros::param::search(from, robot.description, found) ||
      !node_.getParam(found, description.urdf_xml)) {
    throw std::runtime_error("there is no text parameter '" + robot.description + "' in " + from +
                             " or above; load the URDF there, or set ~robot_source to topic");
  }
  description.source = "parameter '" + found + "'";
  description.link_prefix = robot.link_prefix;
  return description;
}

RobotGeometry RobotSource::loadFromDescriptions(const std::vector<Srdf>& srdfs) const {
  std::vector<RobotDescription> descriptions;
  for (const RobotParameters& robot : parameters_.allRobots()) {
    descriptions.push_back(readDescription(robot));
    descriptions.back().srdf = srdfs[descriptions.size() - 1];
  }
  RobotGeometry robot;
  try {
    MeshReading reading;
    // ros::ok() would be too late: it changes after the shutdown has waited for this callback.
    reading.stop = [this] { return is_stopped_ || ros::isShuttingDown(); };
    robot = loadRobots(descriptions, parameters_.geometry, makeRosResolver(), reading);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());
  }
  checkRobot(robot, parameters_);
  return robot;
}

// Applies ~links and ~ignored_links to the links that were sent.
void RobotSource::receive(const LinkMeshes::ConstPtr& message) {
  try {
    RobotGeometry sent = fromLinkMeshes(*message);
    const std::string ignored = ignoredLinksWarning(sent, parameters_.geometry);
    if (!ignored.empty()) ROS_WARN_STREAM(ignored << "; see config/docs/console.md#the-robot");
    RobotGeometry robot = selectedLinks(std::move(sent), parameters_.geometry);
    setSrdfs(parameters_.allRobots(), srdfs_, &robot);
    checkRobot(robot, parameters_);
    if (use(std::move(robot))) changed_();
  } catch (const std::exception& error) {
    reject(error.what());
  }
}

// The sender has newer meshes than those in use, so these may be wrong.
void RobotSource::reject(const std::string& problem) {
  ROS_ERROR_STREAM(
      "the new link meshes are rejected, so every link is UNKNOWN until valid ones come: "
      << problem << "; see config/docs/console.md#the-robot");
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    problem_ = problem;
    if (robot_ == nullptr || isWithoutShapes(*robot_)) return;
    robot_ = std::make_shared<const RobotGeometry>(withoutShapes(*robot_, problem));
  }
  changed_();
}

// Logs before taking the lock, because logging may block and newest() must not wait for it.
bool RobotSource::use(RobotGeometry robot) {
  const std::shared_ptr<const RobotGeometry> old = newest();
  const bool is_new = !old || !same(*old, robot);
  if (is_new) log(robot, parameters_);
  const std::lock_guard<std::mutex> lock(mutex_);
  problem_.clear();
  if (is_new) robot_ = std::make_shared<const RobotGeometry>(std::move(robot));
  return is_new;
}

}  // namespace deformable_contact_monitor
