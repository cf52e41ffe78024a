// scene_publisher: plays mesh files or a simulated cloth as a deforming object, and moves joints.
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <urdf_parser/urdf_parser.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <exception>
#include <iostream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "robot/robot_geometry.h"
#include "tools/common/robot_obstacles.h"
#include "tools/common/scene_object.h"
#include "tools/scene_publisher/joint_mover.h"
#include "tools/scene_publisher/mesh_stream.h"

namespace deformable_contact_monitor {
namespace {

struct Settings {
  SceneObject object;
  std::string topic = "deformable_mesh";
  bool joints = false;
};

void describe(CLI::App* app, Settings* s) {
  describe(app, &s->object);
  app->add_flag("--joints", s->joints,
                "move the joints of robot_description: publish joint_states");
  app->add_option("--topic", s->topic, "where its meshes are published")->capture_default_str();
}

// The robot of the parameter robot_description; nothing if there is none.
struct Robot {
  urdf::ModelInterfaceSharedPtr model;
  RobotGeometry geometry;
};

std::optional<Robot> loadRobot(const ros::NodeHandle& node) {
  std::string key, xml;
  if (!node.searchParam("robot_description", key) || !node.getParam(key, xml)) return std::nullopt;
  Robot robot;
  robot.geometry = loadRobotGeometry(xml, {}, makeRosResolver());
  robot.model = urdf::parseURDF(xml);
  if (robot.model == nullptr) throw std::runtime_error(key + ": urdfdom cannot read it");
  return robot;
}

sensor_msgs::JointState toMessage(const JointMover& mover, double time_s, const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.name = mover.names();
  message.position = mover.positions(time_s);
  return message;
}

int run(const Settings& s) {
  const SceneObject& object = s.object;
  if (!object.isWanted() && !s.joints) {
    throw std::runtime_error("nothing to publish: give --meshes, --cloth or --joints (see --help)");
  }
  ros::Time::init();
  MeshSource source;
  if (object.isWanted()) {  // bad files need no master to be refused
    source = makeMeshSource(object, [&](std::size_t count) {
      ROS_INFO_THROTTLE(1, "read %zu of %zu meshes", count, object.meshes.size());
    });
  }
  ros::NodeHandle node;
  const bool needs_robot = s.joints || object.cloth_triangles > 0;
  const std::optional<Robot> robot = needs_robot ? loadRobot(node) : std::nullopt;
  if (s.joints && !robot) {
    throw std::runtime_error(
        "--joints needs the parameter robot_description; set it and try again");
  }
  const std::string frame =
      !object.frame.empty() ? object.frame : (robot ? robot->model->getRoot()->name : "base_link");
  std::optional<RobotObstacles> obstacles;
  if (robot && object.cloth_triangles > 0) obstacles.emplace(robot->model, robot->geometry, frame);

  std::optional<JointMover> mover;
  ros::Publisher joint_publisher;
  ros::Subscriber joint_subscriber;
  std::map<std::string, double> joints;  // as last known
  if (s.joints) {
    mover.emplace(*robot->model, object.seed);
    joint_publisher = node.advertise<sensor_msgs::JointState>("joint_states", 10);
  } else if (robot) {
    const boost::function<void(const sensor_msgs::JointStateConstPtr&)> remember =
        [&joints](const sensor_msgs::JointStateConstPtr& message) {
          const std::size_t count = std::min(message->name.size(), message->position.size());
          for (std::size_t i = 0; i < count; ++i) joints[message->name[i]] = message->position[i];
        };
    joint_subscriber = node.subscribe<sensor_msgs::JointState>("joint_states", 10, remember);
  }
  MeshStream stream(&node, s.topic, object.name, frame, ros::Duration(1 / object.rate_hz));

  // Time in the scene counts messages, so that the same command gives the same states on any
  // machine, however slow.
  ros::Rate rate(object.rate_hz);
  for (std::uint64_t cycle = 0; ros::ok(); ++cycle) {
    ros::spinOnce();
    const double time_s = static_cast<double>(cycle) / object.rate_hz;
    if (mover) {
      const std::vector<double> positions = mover->positions(time_s);
      for (std::size_t i = 0; i < positions.size(); ++i) joints[mover->names()[i]] = positions[i];
    }
    std::optional<MeshFrame> state;
    if (source) state = source(obstacles ? obstacles->at(joints) : std::vector<Capsule>());
    if (source && !state) break;
    const ros::Time now = ros::Time::now();
    if (mover) joint_publisher.publish(toMessage(*mover, time_s, now));
    if (state) stream.publish(*state, now);
    ROS_INFO_THROTTLE(10, "message %llu, %.1f s into the scene, %zu triangles",
                      static_cast<unsigned long long>(cycle + 1), time_s,
                      state ? state->mesh.triangleCount() : 0);
    rate.sleep();
  }
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  ros::init(argc, argv, "scene_publisher");
  deformable_contact_monitor::Settings settings;
  CLI::App app(
      "Publishes a deforming mesh, from files or as a simulated cloth, and moves a robot.");
  describe(&app, &settings);
  try {
    app.parse(argc, argv);
    return deformable_contact_monitor::run(settings);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    std::cerr << "scene_publisher: " << error.what() << " (see --help)" << std::endl;
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "scene_publisher: " << error.what() << std::endl;
    return 2;
  }
}
