// scene_publisher: publishes mesh files or a simulated cloth as a deforming object, and moves a
// robot's joints.
//
// It replaces a camera and a robot in demonstrations and tests. One loop, at the rate of --rate,
// moves the joints, makes the next state of the object and publishes both with the same stamp.
// Links of the robot push the cloth, as capsules. Everything runs in the main thread.
#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "robot/robot_geometry.h"
#include "robot/urdf_document.h"
#include "tools/common/command_line.h"
#include "tools/common/robot_obstacles.h"
#include "tools/common/ros_words.h"
#include "tools/common/run_tool.h"
#include "tools/common/scene_object.h"
#include "tools/scene_publisher/joint_mover.h"

namespace deformable_contact_monitor {
namespace {

// The options of the command line.
struct Settings {
  SceneObject object;
  std::string topic = "deformable_mesh";
  bool joints = false;
};

// Adds the options to the command line; `s` holds the defaults.
void describe(CommandLine* line, Settings* s) {
  describe(line, &s->object);
  line->addFlag("--joints", &s->joints,
                "move the joints of robot_description: publish joint_states");
  line->add("--topic", &s->topic, "where its meshes are published");
}

// The robot that the parameter robot_description describes: its joints as urdfdom reads them, and
// the meshes of its links.
struct Robot {
  urdf::ModelInterfaceSharedPtr model;
  RobotGeometry geometry;
};

// Loads the robot, or returns nothing if there is no such parameter. Throws std::runtime_error if
// the URDF or one of its meshes cannot be read.
std::optional<Robot> loadRobot(const ros::NodeHandle& node) {
  std::string key, xml;
  if (!node.searchParam("robot_description", key) || !node.getParam(key, xml)) return std::nullopt;
  Robot robot;
  MeshReading reading;
  reading.stop = ros::isShuttingDown;
  robot.geometry = loadRobotGeometry(xml, {}, makeRosResolver(), reading);
  robot.model = urdf::parseURDF(readUrdfText(xml, GeometryKind::kCollision).xml);
  if (robot.model == nullptr) throw std::runtime_error(key + ": urdfdom cannot read it");
  return robot;
}

// The joints of a robot: this program moves them, or listens to joint_states. Without a robot there
// are none.
class Joints {
 public:
  Joints(const Settings& s, const std::optional<Robot>& robot, ros::NodeHandle* node) {
    if (s.joints) {
      mover_.emplace(*robot->model, s.object.seed);
      publisher_ = node->advertise<sensor_msgs::JointState>("joint_states", 10);
    } else if (robot) {
      subscriber_ = node->subscribe("joint_states", 10, &Joints::remember, this);
    }
  }
  Joints(const Joints&) = delete;
  Joints& operator=(const Joints&) = delete;

  // Returns the last known positions, or those at `time_s` of the scene if this program moves them.
  const std::map<std::string, double>& positionsAt(double time_s) {
    if (mover_) {
      const std::vector<double> positions = mover_->positions(time_s);
      for (std::size_t i = 0; i < positions.size(); ++i) {
        positions_[mover_->names()[i]] = positions[i];
      }
    }
    return positions_;
  }

  // Publishes joint_states if this program moves the joints.
  void publish(double time_s, const ros::Time& stamp) const {
    if (!mover_) return;
    sensor_msgs::JointState message;
    message.header.stamp = stamp;
    message.name = mover_->names();
    message.position = mover_->positions(time_s);
    publisher_.publish(message);
  }

 private:
  // Stores positions from joint_states. A message may hold only some of the joints.
  void remember(const sensor_msgs::JointStateConstPtr& message) {
    const std::size_t count = std::min(message->name.size(), message->position.size());
    for (std::size_t i = 0; i < count; ++i) positions_[message->name[i]] = message->position[i];
  }

  std::optional<JointMover> mover_;
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
  std::map<std::string, double> positions_;
};

// Publishes the states of the object. Sends triangles with the first message, whenever topology_id
// changes, and at least once a second of stamps, so that a late subscriber, or one that lost a
// message, does not wait long. Most messages hold only vertices: triangles would make up about two
// thirds of a message.
class MeshStream {
 public:
  MeshStream(const Settings& s, std::string frame_id, ros::NodeHandle* node)
      : publisher_(node->advertise<DeformableMesh>(s.topic, 1)),
        object_(s.object.name),
        frame_id_(std::move(frame_id)),
        period_(1 / s.object.rate_hz) {}

  // Publishes one state with this stamp. Vertices are in metres, in `frame_id`.
  void publish(const MeshFrame& frame, const ros::Time& stamp) {
    DeformableMesh message;
    message.header.stamp = stamp;
    message.header.frame_id = frame_id_;
    message.object = object_;
    message.topology_id = frame.topology_id;
    message.vertices = frame.mesh.vertices;
    // Triangles are due if the next message would be too late for them, or if the clock went back.
    const bool due = triangles_sent_.isZero() || stamp < triangles_sent_ ||
                     stamp + period_ > triangles_sent_ + ros::Duration(1);
    if (due || frame.topology_id != topology_id_) {
      message.triangles = frame.mesh.triangles;
      triangles_sent_ = stamp;
      topology_id_ = frame.topology_id;
    }
    publisher_.publish(message);
  }

 private:
  ros::Publisher publisher_;
  std::string object_, frame_id_;
  ros::Duration period_;      // the expected time between two messages
  ros::Time triangles_sent_;  // stamp of the latest message with triangles; zero: none yet
  std::uint32_t topology_id_ = 0;
};

// Opens the source of the object's states, and reads its files. Returns null if no object is
// wanted.
MeshSource openSource(const SceneObject& object) {
  if (!object.isWanted()) return nullptr;
  return makeMeshSource(object, [&object](std::size_t count) {
    ROS_INFO_THROTTLE(1, "read %zu of %zu meshes", count, object.meshes.size());
  });
}

// Publishes until ROS shuts down or the meshes end. Returns the exit code.
int run(const Settings& s) {
  const SceneObject& object = s.object;
  if (!object.isWanted() && !s.joints) {
    throw std::runtime_error("nothing to publish: give --meshes, --cloth or --joints (see --help)");
  }
  ros::Time::init();
  const MeshSource source =
      openSource(object);  // before the node handle: bad files are rejected without a master
  ros::NodeHandle node;
  const bool needs_robot = s.joints || object.cloth_triangles;
  const std::optional<Robot> robot = needs_robot ? loadRobot(node) : std::nullopt;
  if (s.joints && !robot) {
    throw std::runtime_error(
        "--joints needs the parameter robot_description; set it and try again");
  }
  const std::string frame =
      !object.frame.empty() ? object.frame : (robot ? robot->model->getRoot()->name : "base_link");
  std::optional<RobotObstacles> obstacles;
  if (robot && object.cloth_triangles) obstacles.emplace(robot->model, robot->geometry, frame);
  Joints joints(s, robot, &node);
  MeshStream stream(s, frame, &node);

  // Scene time counts messages, not seconds, so that the same command gives the same states on any
  // machine.
  ros::Rate rate(object.rate_hz);
  for (std::uint64_t cycle = 0; ros::ok(); ++cycle) {
    ros::spinOnce();
    const double time_s = static_cast<double>(cycle) / object.rate_hz;
    const std::map<std::string, double>& positions = joints.positionsAt(time_s);
    std::optional<MeshFrame> state;
    // Obstacles move first, so that the cloth meets the links where they are at this stamp.
    if (source) state = source(obstacles ? obstacles->at(positions) : std::vector<Capsule>());
    if (source && !state) break;
    const ros::Time now = ros::Time::now();
    joints.publish(time_s, now);
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
  namespace dcm = deformable_contact_monitor;
  return dcm::runTool("scene_publisher", [&argc, argv] {
    dcm::Settings settings;
    dcm::CommandLine line(
        "scene_publisher",
        "Publishes a deforming mesh, from files or as a simulated cloth, and moves a robot.");
    describe(&line, &settings);
    if (!line.parse(dcm::wordsForNode(argc, argv))) return 0;
    ros::init(argc, argv, "scene_publisher");
    return dcm::run(settings);
  });
}
