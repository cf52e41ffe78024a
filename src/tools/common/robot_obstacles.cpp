// Turns a robot's links into capsules that push the simulated cloth. A capsule is fitted to each
// link's mesh once; at() moves it with the joints.
#include "tools/common/robot_obstacles.h"

#include <urdf_model/joint.h>
#include <urdf_model/link.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "robot/urdf_document.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kInside = 0.9;  // capsule to mean surface

// A point that stands for a part of the surface. Its weight is the area of that part [m^2].
struct Sample {
  Eigen::Vector3d point;
  double weight;
};

// Edge midpoints weighted by area integrate quadratic functions over the surface exactly.
std::vector<Sample> sampleSurface(const TriangleMesh& mesh) {
  std::vector<Sample> samples;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Eigen::Vector3d corner[3];
    for (std::size_t i = 0; i < 3; ++i) {
      corner[i] =
          Eigen::Map<const Eigen::Vector3f>(&mesh.vertices[3 * std::size_t{mesh.triangles[t + i]}])
              .cast<double>();
    }
    const double area = (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm() / 2;
    if (!(area > 0)) continue;  // a point, a segment, or not finite
    for (int i = 0; i < 3; ++i) {
      samples.push_back({(corner[i] + corner[(i + 1) % 3]) / 2, area / 3});
    }
  }
  return samples;
}

// Converts a URDF pose.
Eigen::Isometry3d toIsometry(const urdf::Pose& pose) {
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  isometry.translate(Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z));
  double x = 0, y = 0, z = 0, w = 1;
  pose.rotation.getQuaternion(x, y, z, w);
  isometry.rotate(Eigen::Quaterniond(w, x, y, z));
  return isometry;
}

// Returns the position of a joint, which may mimic another one; 0 if it is not known.
double positionOf(const urdf::Joint& joint, const std::map<std::string, double>& positions) {
  const std::string& name = joint.mimic == nullptr ? joint.name : joint.mimic->joint_name;
  const auto found = positions.find(unguarded(name));
  const double position = found == positions.end() ? 0 : found->second;
  return joint.mimic == nullptr ? position
                                : joint.mimic->multiplier * position + joint.mimic->offset;
}

// Returns the pose of a joint's child link in the parent link.
Eigen::Isometry3d childPose(const urdf::Joint& joint,
                            const std::map<std::string, double>& positions) {
  Eigen::Isometry3d pose = toIsometry(joint.parent_to_joint_origin_transform);
  const Eigen::Vector3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
  if (joint.type == urdf::Joint::PRISMATIC) {
    pose.translate(positionOf(joint, positions) * axis);
  } else if (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS) {
    pose.rotate(Eigen::AngleAxisd(positionOf(joint, positions), axis.normalized()));
  }
  return pose;
}

}  // namespace

// Integrates area, middle and covariance over the surface. The eigenvector of the largest
// eigenvalue is the capsule's axis, and the other two eigenvalues give its radius.
Capsule fitCapsule(const TriangleMesh& mesh) {
  const std::vector<Sample> samples = sampleSurface(mesh);
  double area = 0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Sample& s : samples) {
    area += s.weight;
    middle += s.weight * s.point;
  }
  middle /= area;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Sample& s : samples) {
    covariance += s.weight / area * (s.point - middle) * (s.point - middle).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Eigen::Vector3d axis = solver.eigenvectors().col(2);
  double first = 0, last = 0;  // along the axis
  for (const Sample& s : samples) {
    const double along = (s.point - middle).dot(axis);
    first = std::min(first, along);
    last = std::max(last, along);
  }
  const double radius = kInside * std::sqrt(solver.eigenvalues()[0] + solver.eigenvalues()[1]);
  const double shift = (first + last) / 2;
  const double half = std::max(0.0, kInside * (last - first) / 2 - radius);
  return {middle + (shift - half) * axis, middle + (shift + half) * axis, radius};
}

// Links without usable geometry do not push the cloth.
std::map<std::string, Capsule> linkCapsules(const RobotGeometry& robot) {
  std::map<std::string, Capsule> capsules;
  for (const LinkGeometry& link : robot.links) {
    if (!link.problem.empty() || sampleSurface(link.mesh).empty()) continue;
    capsules[link.link] = fitCapsule(link.mesh);
  }
  return capsules;
}

RobotObstacles::RobotObstacles(urdf::ModelInterfaceSharedPtr robot, const RobotGeometry& geometry,
                               std::string frame)
    : robot_(std::move(robot)), capsules_(linkCapsules(geometry)), frame_(std::move(frame)) {
  if (robot_->getLink(guarded(frame_)) == nullptr) {
    throw std::invalid_argument("frame '" + frame_ + "' is no link of robot '" +
                                unguarded(robot_->getName()) + "'");
  }
}

// Walks down the tree of links. All poses are in the root's frame.
void RobotObstacles::place(const urdf::Link& link, const Eigen::Isometry3d& pose,
                           const std::map<std::string, double>& positions,
                           std::map<std::string, Eigen::Isometry3d>* poses) const {
  (*poses)[unguarded(link.name)] = pose;
  for (const auto& joint : link.child_joints) {
    place(*robot_->getLink(joint->child_link_name), pose * childPose(*joint, positions), positions,
          poses);
  }
}

// Computes all poses first, and then expresses the capsules in the cloth's frame.
std::vector<Capsule> RobotObstacles::at(const std::map<std::string, double>& positions) const {
  std::map<std::string, Eigen::Isometry3d> poses;
  place(*robot_->getRoot(), Eigen::Isometry3d::Identity(), positions, &poses);
  const Eigen::Isometry3d to_frame = poses.at(frame_).inverse();
  std::vector<Capsule> obstacles;
  for (const auto& [link, capsule] : capsules_) {
    const Eigen::Isometry3d pose = to_frame * poses.at(link);
    obstacles.push_back({pose * capsule.a, pose * capsule.b, capsule.radius_m});
  }
  return obstacles;
}

}  // namespace deformable_contact_monitor
