// Where the robot's link meshes come from: robot_description, or a topic.
#pragma once

#include <deformable_contact_monitor/LinkMeshes.h>
#include <ros/node_handle.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

class RobotSource {
 public:
  // With robot_source urdf, loads the robot; throws std::runtime_error if there is none, it is
  // malformed, or (strict_geometry) a link has no usable geometry; ReadingStopped if ROS shuts down
  // meanwhile. With robot_source topic, subscribes to ~robot_link_meshes, a latched topic that may
  // come late, again and changed. Either has the rules of the SRDF. One that ~srdf names and that
  // cannot be used is an error of that kind, too; one that was merely found is a srdfProblem().
  // `changed` is called from a callback thread after a new robot is there; the parameters must
  // outlive this.
  RobotSource(const MonitorParameters& parameters, const ros::NodeHandle& node,
              ros::NodeHandle private_node, std::function<void()> changed);

  // The newest robot, null while there is none; another object means another robot. Any thread.
  std::shared_ptr<const RobotGeometry> newest() const;

  // Why the latest one that was offered is not in use; empty: it is. Any thread.
  std::string problem() const;

  // Why links touch without an SRDF's rules although there is one; empty: they do not. Any thread.
  std::string srdfProblem() const;

  // Reads robot_description and the SRDF again. Throws as the constructor does, also at an SRDF
  // that was merely found, and then keeps the robot; also if the robot comes from a topic. A bad
  // mesh file may keep it waiting for kMaxRobotTime.
  void reload();

  // Ends a reload that is under way, as ROS's shutdown does, and every later one. Any thread.
  void stop() { is_stopped_ = true; }

 private:
  RobotGeometry loadFromDescription() const;
  std::string searchNamespace() const;
  Srdf loadSrdf() const;
  void loadFirstSrdf();
  void receive(const LinkMeshes::ConstPtr& message);
  // Keeps the robot unless it is what is there already; returns whether it did.
  bool use(RobotGeometry robot);

  const MonitorParameters& parameters_;
  const ros::NodeHandle node_;
  const std::function<void()> changed_;
  std::atomic<bool> is_stopped_{false};
  ros::Subscriber subscriber_;

  mutable std::mutex mutex_;
  std::shared_ptr<const RobotGeometry> robot_;
  std::string problem_, srdf_problem_;
  Srdf srdf_;  // of robots that come from a topic
};

}  // namespace deformable_contact_monitor
