// Provides the robots' link meshes, from robot_description or from a topic.
#pragma once

#include <deformable_contact_monitor/LinkMeshes.h>
#include <ros/node_handle.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Holds the newest robot, with the rules of its SRDF. Several robots (~robots) are one robot here,
// whose links have the names with their prefixes. Every function may be called by any thread.
class RobotSource {
 public:
  // Loads the robot (robot_source: urdf), or subscribes to the latched topic ~robot_link_meshes
  // (robot_source: topic), which may come late, and again with changed meshes; as long as the
  // newest message is rejected, no link has a shape. Throws std::runtime_error if the robot is
  // missing or malformed, if a link has no usable geometry (strict_geometry), if two links have one
  // name, or if the SRDF that ~srdf names cannot be used; an SRDF that was only found becomes a
  // srdfProblem(). Throws ReadingStopped if ROS shuts down meanwhile. `changed` is called from a
  // callback thread after each new robot. The parameters must outlive this.
  RobotSource(const MonitorParameters& parameters, const ros::NodeHandle& node,
              ros::NodeHandle private_node, std::function<void()> changed);

  // Returns the newest robot, null while there is none. A new object means a new robot.
  std::shared_ptr<const RobotGeometry> newest() const { return get(robot_); }

  // Returns why the latest robot that was offered is not used; empty if it is.
  std::string problem() const { return get(problem_); }

  // Returns why an SRDF that was found is not used; empty if there is no such problem.
  std::string srdfProblem() const { return get(srdf_problem_); }

  // Loads robot_description and the SRDF again. Throws as the constructor does, and also if an SRDF
  // that was only found cannot be used, or if the robot comes from a topic; then the robot stays as
  // it was. A bad mesh file may take up to kMaxRobotTime.
  void reload();

  // Ends a reload that runs, like a shutdown of ROS, and rejects every later one.
  void stop() { is_stopped_ = true; }

 private:
  template <class Value>
  Value get(const Value& member) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return member;
  }
  // Loads and checks the robots of the parameters with the URDFs. Throws std::runtime_error.
  RobotGeometry loadFromDescriptions(const std::vector<Srdf>& srdfs) const;
  // Reads the URDF of one robot. Throws std::runtime_error.
  RobotDescription readDescription(const RobotParameters& robot) const;
  // Returns the namespace from which parameters are searched for upwards.
  std::string searchNamespace() const;
  // Loads what a robot's `srdf` says. Throws std::runtime_error if it exists and cannot be used.
  Srdf loadSrdf(const RobotParameters& robot) const;
  // Loads the first SRDFs. If one was only found (srdf: auto) and is bad, the node starts without
  // it.
  void loadFirstSrdfs();
  // Takes a robot from the topic.
  void receive(const LinkMeshes::ConstPtr& message);
  // Rejects a message of the topic. Keeps the links of the newest robot, without their shapes.
  void reject(const std::string& problem);
  // Keeps the robot unless it equals the newest one. Returns whether the robot is new. Either way,
  // the problem of an earlier robot is forgotten.
  bool use(RobotGeometry robot);

  const MonitorParameters& parameters_;
  const ros::NodeHandle node_;
  const std::function<void()> changed_;
  std::atomic<bool> is_stopped_{false};
  ros::Subscriber subscriber_;

  mutable std::mutex mutex_;  // guards the members below
  std::shared_ptr<const RobotGeometry> robot_;
  std::string problem_, srdf_problem_;
  std::vector<Srdf> srdfs_;  // of robots that come from a topic
};

}  // namespace deformable_contact_monitor
