// Deformable bodies whose size or distance cannot be meant: a mesh in millimetres, say.
#include "monitor/diagnostics/size_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

namespace deformable_contact_monitor {
namespace {

constexpr double kOddFactor = 100;

struct Box {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double low[3] = {kInfinity, kInfinity, kInfinity};
  double high[3] = {-kInfinity, -kInfinity, -kInfinity};

  void add(const double (&point)[3]) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], point[axis]);
      high[axis] = std::max(high[axis], point[axis]);
    }
  }

  bool isEmpty() const { return low[0] > high[0]; }

  double largestSide() const {
    double side = 0;
    for (int axis = 0; axis < 3; ++axis) side = std::max(side, high[axis] - low[axis]);
    return side;
  }
};

// In the body's frame; vertices that are not finite are left out.
Box boxOf(const TriangleMesh& mesh) {
  Box box;
  for (std::size_t i = 0; i + 2 < mesh.vertices.size(); i += 3) {
    const float* const v = &mesh.vertices[i];
    if (std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2])) {
      box.add({v[0], v[1], v[2]});
    }
  }
  return box;
}

// Around the box in its pose.
void addPosed(const Box& box, const RigidTransform& pose, Box* all) {
  for (int corner = 0; !box.isEmpty() && corner < 8; ++corner) {
    double posed[3];
    for (int axis = 0; axis < 3; ++axis) {
      posed[axis] = pose.translation[axis];
      for (int i = 0; i < 3; ++i) {
        const bool is_high = ((corner >> i) & 1) != 0;
        posed[axis] += pose.rotation[3 * axis + i] * (is_high ? box.high[i] : box.low[i]);
      }
    }
    all->add(posed);
  }
}

// 0: they meet.
double gap(const Box& a, const Box& b) {
  double squares = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double apart = std::max({a.low[axis] - b.high[axis], b.low[axis] - a.high[axis], 0.0});
    squares += apart * apart;
  }
  return std::sqrt(squares);
}

// Of the links that were posed in this cycle.
Box robotBox(const CycleReport& report) {
  Box robot;
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const BodyStatus& status = report.bodies[id];
    if (status.kind != BodyKind::kLink || status.stamp.isZero()) continue;
    addPosed(boxOf(report.scene->body(id).mesh), report.scene->body(id).pose, &robot);
  }
  return robot;
}

std::string whatIsOdd(const Box& body, const Box& robot) {
  std::ostringstream text;
  const double robot_m = robot.largestSide();
  if (body.largestSide() > kOddFactor * robot_m) {
    text << "its mesh is " << body.largestSide() << " m long, and the robot " << robot_m
         << " m; is it in millimetres?";
  } else if (gap(body, robot) > kOddFactor * robot_m) {
    text << "its mesh is " << gap(body, robot) << " m away from the robot, which is " << robot_m
         << " m long; check its unit and its frame";
  }
  return text.str();
}

}  // namespace

std::vector<SizeCheck::Finding> SizeCheck::look(const CycleReport& report, SteadyTime now) {
  std::vector<Finding> findings;
  std::optional<Box> robot;
  for (BodyId id = 0; report.scene != nullptr && id < report.bodies.size(); ++id) {
    const BodyStatus& status = report.bodies[id];
    const bool is_here = status.triggered && status.unknown_because.empty();
    if (status.kind != BodyKind::kDeformable || !is_here || now < due_[status.name]) continue;
    due_[status.name] = now + std::chrono::seconds(1);
    if (!robot) robot = robotBox(report);
    if (robot->isEmpty() || robot->largestSide() <= 0) break;
    Box body;
    addPosed(boxOf(report.scene->body(id).mesh), report.scene->body(id).pose, &body);
    findings.emplace_back(status.name, body.isEmpty() ? "" : whatIsOdd(body, *robot));
  }
  return findings;
}

}  // namespace deformable_contact_monitor
