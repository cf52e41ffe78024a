// Warns about links that are usable but unusual (their size, triangles, non-finite vertices), and
// about joints that form no tree.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {
namespace {

// Links outside these sizes are rare. A wrong unit is the usual reason: a mesh in millimetres that
// is read as metres is 1000 times too long.
constexpr double kLargestLink_m = 10;
constexpr double kSmallestLink_m = 1e-3;
constexpr std::size_t kManyTriangles = 200000;

struct Extent {
  double largest_m = 0;        // longest side of the bounding box; 0: no finite vertex
  std::size_t non_finite = 0;  // vertices
};

// Measures the finite vertices and counts the others.
Extent measure(const TriangleMesh& mesh) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double low[3] = {kInfinity, kInfinity, kInfinity};
  double high[3] = {-kInfinity, -kInfinity, -kInfinity};
  Extent extent;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    const float* v = &mesh.vertices[i];
    if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) {
      ++extent.non_finite;
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min<double>(low[axis], v[axis]);
      high[axis] = std::max<double>(high[axis], v[axis]);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    extent.largest_m = std::max(extent.largest_m, high[axis] - low[axis]);
  }
  return extent;
}

// Names the links that have geometry of the other kind only.
std::string unmonitoredLinks(const RobotGeometry& robot) {
  const bool is_visual = robot.kind == GeometryKind::kVisual;
  std::string names;
  for (const std::string& name : robot.unmonitored_links) {
    names += (names.empty() ? "'" : ", '") + name + "'";
  }
  return "links with " +
         std::string(is_visual ? "collision but no visual" : "visual but no collision") +
         " geometry are not monitored: " + names +
         "; set geometry to collision_or_visual to monitor them";
}

// Warns of loops and bad mimics that urdfdom accepts. Poses come from TF, so they stay right.
std::vector<std::string> jointWarnings(const std::vector<RobotJoint>& joints) {
  std::vector<std::string> warnings;
  std::set<std::string> said;  // joints of one loop have one problem
  for (const RobotJoint& joint : joints) {
    for (const std::string& problem : {joint.tree_problem, joint.mimic_problem}) {
      if (problem.empty() || !said.insert(problem).second) continue;
      warnings.push_back(problem +
                         "; links stand where TF says, but a question that moves these is refused");
    }
  }
  return warnings;
}

}  // namespace

double linkLengthM(const LinkGeometry& link) { return measure(link.mesh).largest_m; }

std::vector<std::string> geometryWarnings(const RobotGeometry& robot) {
  std::vector<std::string> warnings = jointWarnings(robot.joints);
  if (!robot.unmonitored_links.empty()) warnings.push_back(unmonitoredLinks(robot));
  for (const LinkGeometry& link : robot.links) {
    if (!link.problem.empty()) continue;
    const auto warn = [&](const auto&... parts) {
      std::ostringstream text;
      text << "link '" << link.link << "' (" << link.source << "): ";
      (text << ... << parts);
      warnings.push_back(text.str());
    };
    const Extent extent = measure(link.mesh);
    if (extent.largest_m > kLargestLink_m) {
      warn(extent.largest_m, " m long; if its file is in millimetres, give the mesh a scale");
    }
    if (extent.largest_m < kSmallestLink_m) {
      warn("only ", extent.largest_m, " m long; check the mesh's unit and scale");
    }
    if (link.mesh.triangleCount() > kManyTriangles) {
      warn(link.mesh.triangleCount(), " triangles; a coarser collision mesh is faster");
    }
    if (extent.non_finite > 0) {
      warn(extent.non_finite, " vertices are not finite; their triangles take no part");
    }
    for (const std::string& note : link.notes) {
      warnings.push_back("link '" + link.link + "': " + note);
    }
  }
  return warnings;
}

}  // namespace deformable_contact_monitor
