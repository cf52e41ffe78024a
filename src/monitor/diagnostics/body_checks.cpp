// Finds bodies whose meshes are probably not what the user meant.
//
// The size check compares boxes only, so it costs one pass over the vertices per object and second.
#include "monitor/diagnostics/body_checks.h"

#include <Eigen/Geometry>
#include <optional>
#include <sstream>

namespace deformable_contact_monitor {
namespace {

constexpr double kAnomalousFactor = 100;  // times the robot's largest side

// Boxes in double precision, which holds the sizes that this check looks for.
using Box = Eigen::AlignedBox3d;

double largestSide(const Box& box) { return box.isEmpty() ? 0 : box.sizes().maxCoeff(); }

// Returns how many parts are open, as "1 of 3 parts".
std::string openParts(const Containment::Components& parts) {
  return std::to_string(parts.open) + " of " + std::to_string(parts.all) + " parts";
}

// Returns the box of the finite vertices, in the body's frame.
Box boxOf(const TriangleMesh& mesh) {
  Box box;
  for (std::size_t i = 0; i + 2 < mesh.vertices.size(); i += 3) {
    const Eigen::Map<const Eigen::Vector3f> vertex(&mesh.vertices[i]);
    if (vertex.array().isFinite().all()) box.extend(vertex.cast<double>());
  }
  return box;
}

// Extends `all` by the eight corners of the box in that pose.
void addPosed(const Box& box, const RigidTransform& pose, Box* all) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(pose.rotation);
  const Eigen::Map<const Eigen::Vector3d> translation(pose.translation);
  for (int corner = 0; !box.isEmpty() && corner < 8; ++corner) {
    all->extend(rotation * box.corner(static_cast<Box::CornerType>(corner)) + translation);
  }
}

// Returns the box of the links that have a pose in this cycle.
Box robotBox(const CycleReport& report) {
  Box robot;
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const BodyStatus& status = report.bodies[id];
    if (status.kind != BodyKind::kLink || status.stamp.isZero()) continue;
    addPosed(boxOf(report.scene->body(id).mesh), report.scene->body(id).pose, &robot);
  }
  return robot;
}

// Returns what is anomalous about an object, and what to check; empty: nothing.
std::string describeAnomaly(const Box& body, const Box& robot) {
  std::ostringstream text;
  const double robot_m = largestSide(robot);
  if (largestSide(body) > kAnomalousFactor * robot_m) {
    text << "its mesh is " << largestSide(body) << " m long, and the robot " << robot_m
         << " m; is it in millimetres?";
  } else if (body.exteriorDistance(robot) > kAnomalousFactor * robot_m) {
    text << "its mesh is " << body.exteriorDistance(robot) << " m away from the robot, which is "
         << robot_m << " m long; check its unit and its frame";
  }
  return text.str();
}

}  // namespace

// Bodies that this cycle did not examine keep what was found before.
std::vector<std::string> OpenBodies::look(const CycleReport& report) {
  std::vector<std::string> lines;
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const Containment::Components& parts = report.containment->bodies.at(id);
    if (!parts.looked_at) continue;
    const std::string& body = report.bodies[id].name;
    open_.erase(body);
    if (parts.open == 0) continue;
    const std::string count = openParts(parts);
    open_[body] = count;
    if (!reported_.insert(body).second) continue;
    lines.push_back(std::string("containment: ").append(count).append(" of '").append(body) +
                    "' are not closed, so nothing is reported as inside of them; close the "
                    "surface where that matters");
  }
  return lines;
}

std::string OpenBodies::list() const {
  std::string all;
  for (const auto& [body, count] : open_) {
    all.append(all.empty() ? "" : ", ").append(body).append(" (").append(count).append(")");
  }
  return all;
}

// Computes the robot's box only when an object is due.
std::vector<SizeCheck::Finding> SizeCheck::look(const CycleReport& report, SteadyTime now) {
  std::vector<Finding> findings;
  std::optional<Box> robot;
  for (BodyId id = 0; report.scene != nullptr && id < report.bodies.size(); ++id) {
    const BodyStatus& status = report.bodies[id];
    const bool is_here = status.triggered && status.unknown_because.empty();
    if (status.kind != BodyKind::kDeformable || !is_here || now < due_[status.name]) continue;
    due_[status.name] = now + std::chrono::seconds(1);
    const TriangleMesh& mesh = report.scene->body(id).mesh;
    Box body;
    addPosed(boxOf(mesh), report.scene->body(id).pose, &body);
    if (body.isEmpty()) {
      const std::string count = std::to_string(mesh.vertexCount());
      findings.emplace_back(status.name, mesh.vertexCount() == 0
                                             ? ""
                                             : "none of its " + count + " vertices is finite");
      continue;
    }
    if (!robot) robot = robotBox(report);
    if (robot->isEmpty() || largestSide(*robot) <= 0) continue;
    findings.emplace_back(status.name, describeAnomaly(body, *robot));
  }
  return findings;
}

}  // namespace deformable_contact_monitor
