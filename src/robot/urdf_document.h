// Reads a URDF's links in document order, with their geometry as urdfdom understands it.
//
// urdfdom stops at the first element that it dislikes and prints its messages. So the document is
// first copied without everything that geometry does not need (readUrdfText), then urdfdom parses
// the copy, and its messages become the problem of the link that they name (readUrdf).
#pragma once

#include <urdf_model/link.h>

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "robot/robot_joint.h"

namespace deformable_contact_monitor {

// Selects the elements of a link: its collision elements, its visual elements, or the collision
// elements, and the visual ones only of a link that has no others.
enum class GeometryKind { kCollision, kVisual, kCollisionOrVisual };

// Names of the kinds in parameters and options, in the order of the enum.
constexpr std::array<const char*, 3> kGeometryKinds = {"collision", "visual",
                                                       "collision_or_visual"};

// The part of a URDF that says where each link's geometry is, as text that is safe for urdfdom.
struct UrdfText {
  struct Link {
    std::string name;
    int line = 0;
    std::size_t elements = 0;  // collision or visual elements
    bool is_visual = false;    // they are visual elements
    bool has_others = false;   // there are elements of the other kind
  };

  std::string xml;          // robot, links with one kind of geometry, joints; guarded (see below)
  std::vector<Link> links;  // document order, names unique and not empty
  std::map<std::string, int> joint_lines;
};

// urdfdom 3.0.1 passes text of the document to printf as a format, so no '%' may reach it.
// `guarded` replaces each '%' by a character that XML forbids, `unguarded` restores it.
std::string guarded(std::string text);
std::string unguarded(std::string text);

// Parses and checks the document. The parts that geometry does not depend on (materials, inertia,
// plugins, the other kind of geometry, comments) are left out, so they may be malformed.
// Throws std::invalid_argument, "robot description, line N: <what>".
UrdfText readUrdfText(const std::string& urdf_xml, GeometryKind kind);

// One collision or visual element of a link.
struct UrdfElement {
  Eigen::Affine3d origin = Eigen::Affine3d::Identity();  // link from geometry [m]
  urdf::GeometrySharedPtr geometry;                      // never null
};

// A link with all its elements of the kind that was asked for.
struct UrdfLink {
  std::string name;
  std::vector<UrdfElement> elements;  // document order
  std::string problem;                // why the elements could not be read; empty: they could
  bool has_others = false;            // the link has elements of the other kind
};

struct UrdfDocument {
  std::string name;
  std::string root_link;
  std::vector<UrdfLink> links;       // document order
  std::vector<RobotJoint> joints{};  // by name
};

// Reads a robot description. A link whose elements are malformed gets a problem, and the others are
// read on. Throws std::invalid_argument, naming element and line where there is one, if the
// document is not a robot. Prints nothing. Thread-safe: callers wait for each other, because the
// parser's messages go through console_bridge's one handler.
UrdfDocument readUrdf(const std::string& urdf_xml, GeometryKind kind);

}  // namespace deformable_contact_monitor
