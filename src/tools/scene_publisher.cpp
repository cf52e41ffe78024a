// scene_publisher: plays mesh files or a simulated cloth as a deforming object, and moves joints.
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <urdf_parser/urdf_parser.h>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <cstdint>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "robot/robot_geometry.h"
#include "tools/cloth.h"
#include "tools/joint_mover.h"
#include "tools/mesh_player.h"
#include "tools/mesh_stream.h"
#include "tools/robot_obstacles.h"

namespace deformable_contact_monitor {
namespace {

struct Settings {
  std::vector<std::string> meshes;
  int cloth_triangles = 0;  // 0: no cloth
  bool joints = false;
  bool loop = false;
  std::string object = "cloth";
  std::string topic = "deformable_mesh";
  std::string frame;  // empty: the robot's root link
  double rate_hz = 30;
  double scale = 1;
  std::vector<double> offset = {0, 0, 0};
  std::uint32_t seed = 1;
};

void describe(CLI::App* app, Settings* s) {
  auto* meshes = app->add_option("--meshes", s->meshes,
                                 "mesh files (OBJ, PLY, STL, OFF), played in this order");
  app->add_option("--cloth", s->cloth_triangles,
                  "make a square cloth of about so many triangles that is held at one edge, falls, "
                  "and is pushed by the robot")
      ->check(CLI::Range(2, 2000000))
      ->excludes(meshes);
  app->add_flag("--joints", s->joints,
                "move the joints of robot_description: publish joint_states");
  app->add_flag("--loop", s->loop, "play the files again and again");
  app->add_option("--object", s->object, "name of the object")->capture_default_str();
  app->add_option("--topic", s->topic, "where its meshes are published")->capture_default_str();
  app->add_option("--frame", s->frame,
                  "frame of the vertices; a link, for --cloth (default: the robot's root link)");
  app->add_option("--rate", s->rate_hz, "messages a second [Hz]")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  app->add_option("--scale", s->scale, "meshes: factor to metres; cloth: its edge [m]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app->add_option("--offset", s->offset,
                  "x y z [m]: meshes: added after scaling; cloth: middle of the held edge")
      ->expected(3);
  app->add_option("--seed", s->seed, "of the cloth and of the joints")->capture_default_str();
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

// What each cycle shows: the next state of the object; nothing when the files are at their end.
using Source = std::function<std::optional<MeshFrame>(const std::map<std::string, double>& joints)>;

Source playFiles(const Settings& s) {
  auto frames = readMeshFrames(
      s.meshes, s.scale, Eigen::Vector3d::Map(s.offset.data()), [&](std::size_t count) {
        ROS_INFO_THROTTLE(1, "read %zu of %zu meshes", count, s.meshes.size());
      });
  return [frames = std::move(frames), loop = s.loop,
          next = std::size_t{0}](const auto&) mutable -> std::optional<MeshFrame> {
    if (next == frames.size()) {
      if (!loop) return std::nullopt;
      next = 0;
    }
    return frames[next++];
  };
}

Source simulateCloth(const Settings& s, const std::string& frame,
                     const std::optional<Robot>& robot) {
  std::shared_ptr<RobotObstacles> obstacles;
  if (robot) obstacles = std::make_shared<RobotObstacles>(robot->model, robot->geometry, frame);
  ClothOptions options;
  options.triangles = s.cloth_triangles;
  options.edge_m = s.scale;
  options.held_at = Eigen::Vector3d::Map(s.offset.data());
  options.seed = s.seed;
  return [cloth = Cloth(options), obstacles, dt_s = 1 / s.rate_hz](
             const std::map<std::string, double>& joints) mutable -> std::optional<MeshFrame> {
    cloth.step(dt_s, obstacles ? obstacles->at(joints) : std::vector<Capsule>());
    return MeshFrame{cloth.mesh(), 0};
  };
}

sensor_msgs::JointState toMessage(const JointMover& mover, double time_s, const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.name = mover.names();
  message.position = mover.positions(time_s);
  return message;
}

int run(const Settings& s) {
  if (s.meshes.empty() && s.cloth_triangles == 0 && !s.joints) {
    throw std::runtime_error("nothing to publish: give --meshes, --cloth or --joints (see --help)");
  }
  ros::Time::init();
  Source source;
  if (!s.meshes.empty()) source = playFiles(s);  // bad files need no master to be refused
  ros::NodeHandle node;
  const bool needs_robot = s.joints || s.cloth_triangles > 0;
  const std::optional<Robot> robot = needs_robot ? loadRobot(node) : std::nullopt;
  if (s.joints && !robot) {
    throw std::runtime_error(
        "--joints needs the parameter robot_description; set it and try again");
  }
  const std::string frame =
      !s.frame.empty() ? s.frame : (robot ? robot->model->getRoot()->name : "base_link");

  std::optional<JointMover> mover;
  ros::Publisher joint_publisher;
  ros::Subscriber joint_subscriber;
  std::map<std::string, double> joints;  // as last known
  if (s.joints) {
    mover.emplace(*robot->model, s.seed);
    joint_publisher = node.advertise<sensor_msgs::JointState>("joint_states", 10);
  } else if (robot) {
    const boost::function<void(const sensor_msgs::JointStateConstPtr&)> remember =
        [&joints](const sensor_msgs::JointStateConstPtr& message) {
          const std::size_t count = std::min(message->name.size(), message->position.size());
          for (std::size_t i = 0; i < count; ++i) joints[message->name[i]] = message->position[i];
        };
    joint_subscriber = node.subscribe<sensor_msgs::JointState>("joint_states", 10, remember);
  }
  if (s.cloth_triangles > 0) source = simulateCloth(s, frame, robot);
  MeshStream stream(&node, s.topic, s.object, frame, ros::Duration(1 / s.rate_hz));

  // Time in the scene counts messages, so that the same command gives the same states on any
  // machine, however slow.
  ros::Rate rate(s.rate_hz);
  for (std::uint64_t cycle = 0; ros::ok(); ++cycle) {
    ros::spinOnce();
    const double time_s = static_cast<double>(cycle) / s.rate_hz;
    if (mover) {
      const std::vector<double> positions = mover->positions(time_s);
      for (std::size_t i = 0; i < positions.size(); ++i) joints[mover->names()[i]] = positions[i];
    }
    std::optional<MeshFrame> state;
    if (source) state = source(joints);
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
