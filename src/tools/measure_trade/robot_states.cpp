#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "core/mesh_file.h"
#include "robot/robot_geometry.h"
#include "robot/robot_poses.h"
#include "tools/measure_trade/state_measurement.h"

namespace deformable_contact_monitor {
namespace {

std::string textOf(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return text.str();
}

// Returns random positions of joints, within their limits.
std::vector<double> randomPositions(const std::vector<RobotJoint>& joints, std::mt19937* random) {
  constexpr double kTurn = 3.14159265358979323846;
  std::vector<double> positions;
  for (const RobotJoint& joint : joints) {
    const double lower = std::max(joint.lower, -kTurn), upper = std::min(joint.upper, kTurn);
    positions.push_back(lower + (upper - lower) * ((*random)() * 0x1p-32));
  }
  return positions;
}

}  // namespace

SceneStates makeRobotStates(const RobotStateFiles& files, std::size_t count, std::uint32_t seed) {
  const RobotGeometry robot = loadRobotGeometry(textOf(files.urdf), {}, makeRosResolver());
  RobotPoses robot_poses(robot, "");
  std::vector<RigidTransform> poses(robot_poses.links().size());
  robot_poses.pose(std::vector<double>(robot_poses.joints().size(), 0).data(), poses.data());

  SceneStates states;
  states.scene.addBody("mesh", readMeshFile(files.mesh));
  states.scene.setMargin(0, files.margin_m);
  std::vector<std::size_t> moved;  // places among the links
  for (const LinkGeometry& link : robot.links) {
    if (!link.problem.empty()) throw std::runtime_error(link.link + ": " + link.problem);
    const auto& links = robot_poses.links();
    const auto place =
        static_cast<std::size_t>(std::find(links.begin(), links.end(), link.link) - links.begin());
    const BodyId id = states.scene.addBody(link.link, link.mesh);
    states.scene.setPose(id, poses[place]);
    states.scene.setPairEnabled(0, id, true);
    if (place >= robot_poses.movedCount()) continue;
    moved.push_back(place);
    states.moved.push_back(id);
  }
  if (moved.empty()) {
    throw std::invalid_argument(files.urdf + ": no joint moves a link with a collision mesh");
  }
  std::mt19937 random(seed);
  for (std::size_t state = 0; state < count; ++state) {
    robot_poses.pose(randomPositions(robot_poses.joints(), &random).data(), poses.data());
    for (const std::size_t i : moved) states.poses.push_back(poses[i]);
  }
  return states;
}

}  // namespace deformable_contact_monitor
