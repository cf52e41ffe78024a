#include "tools/measure_trade/robot_states.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/mesh_file.h"
#include "robot/robot_geometry.h"
#include "robot/robot_kinematics.h"

namespace deformable_contact_monitor {
namespace {

RigidTransform toTransform(const urdf::Pose& pose) {
  RigidTransform out;
  for (int c = 0; c < 3; ++c) {
    const urdf::Vector3 column =
        pose.rotation * urdf::Vector3(c == 0 ? 1 : 0, c == 1 ? 1 : 0, c == 2 ? 1 : 0);
    out.rotation[c] = column.x;
    out.rotation[3 + c] = column.y;
    out.rotation[6 + c] = column.z;
  }
  out.translation[0] = pose.position.x;
  out.translation[1] = pose.position.y;
  out.translation[2] = pose.position.z;
  return out;
}

// Returns parent_from_child = a b.
RigidTransform composed(const RigidTransform& a, const RigidTransform& b) {
  RigidTransform out = a;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      out.rotation[3 * r + c] = 0;
      for (int k = 0; k < 3; ++k) {
        out.rotation[3 * r + c] += a.rotation[3 * r + k] * b.rotation[3 * k + c];
      }
      out.translation[r] += a.rotation[3 * r + c] * b.translation[c];
    }
  }
  return out;
}

std::string textOf(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return text.str();
}

// Returns the place of a link that no joint with a position carries, in the root's frame. Joints of
// other types are at their origins.
RigidTransform placeOf(const RobotGeometry& robot, const std::string& link) {
  for (const RobotJoint& joint : robot.joints) {
    if (joint.child != link) continue;
    return composed(placeOf(robot, joint.parent), toTransform(joint.origin));
  }
  return RigidTransform();
}

// Draws positions of all joints that have limits of their own.
class RandomJoints {
 public:
  RandomJoints(const RobotGeometry& robot, std::uint32_t seed) : random_(seed) {
    constexpr double kTurn = 3.14159265358979323846;
    for (const RobotJoint& joint : robot.joints) {
      if (!joint.hasPosition() || !joint.mimics.empty()) continue;
      names_.push_back(joint.name);
      limits_.emplace_back(std::max(joint.lower, -kTurn), std::min(joint.upper, kTurn));
    }
  }

  const std::vector<std::string>& names() const { return names_; }

  std::vector<double> next() {
    std::vector<double> positions;
    for (const auto& [lower, upper] : limits_) {
      positions.push_back(lower + (upper - lower) * (random_() * 0x1p-32));
    }
    return positions;
  }

 private:
  std::mt19937 random_;
  std::vector<std::string> names_;
  std::vector<std::pair<double, double>> limits_;
};

}  // namespace

SceneStates makeRobotStates(const RobotStateFiles& files, std::size_t count, std::uint32_t seed) {
  const RobotGeometry robot = loadRobotGeometry(textOf(files.urdf), {}, makeRosResolver());
  RandomJoints joints(robot, seed);
  JointMotion motion(robot.joints, joints.names());
  std::vector<RigidTransform> present;
  for (const std::string& link : motion.presentLinks()) present.push_back(placeOf(robot, link));
  motion.setPresent(present);

  SceneStates states;
  states.scene.addBody("mesh", readMeshFile(files.mesh));
  states.scene.setMargin(0, files.margin_m);
  std::map<std::string, BodyId> bodies;
  for (const LinkGeometry& link : robot.links) {
    if (!link.problem.empty()) throw std::runtime_error(link.link + ": " + link.problem);
    const BodyId id = states.scene.addBody(link.link, link.mesh);
    states.scene.setPose(id, placeOf(robot, link.link));
    states.scene.setPairEnabled(0, id, true);
    bodies[link.link] = id;
  }
  std::vector<std::size_t> moved;  // places among the links that the joints move
  for (std::size_t i = 0; i < motion.movedLinks().size(); ++i) {
    const auto found = bodies.find(motion.movedLinks()[i]);
    if (found == bodies.end()) continue;
    moved.push_back(i);
    states.moved.push_back(found->second);
  }
  if (moved.empty()) {
    throw std::invalid_argument(files.urdf + ": no joint moves a link with a collision mesh");
  }
  std::vector<RigidTransform> poses(motion.movedLinks().size());
  for (std::size_t state = 0; state < count; ++state) {
    motion.pose(joints.next().data(), poses.data());
    for (const std::size_t i : moved) states.poses.push_back(poses[i]);
  }
  return states;
}

}  // namespace deformable_contact_monitor
