// The part of a URDF's text that says where a link's geometry is, made safe for urdfdom.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

struct UrdfText {
  struct Link {
    std::string name;
    int line = 0;
    std::size_t elements = 0;  // collision or visual elements
  };

  std::string xml;          // robot, links with one kind of geometry, joints; guarded, see below
  std::vector<Link> links;  // document order, names unique and not empty
  std::map<std::string, int> joint_lines;
};

// urdfdom 3.0.1 hands text of the document to printf as a format: no '%' may reach it. `guarded`
// replaces them by a character that XML forbids, `unguarded` brings them back.
std::string guarded(std::string text);
std::string unguarded(std::string text);

// Parses and checks the document. What geometry does not depend on (materials, inertia, plugins,
// the other kind of geometry, comments) is left out, and costs nothing if it is malformed.
// Throws std::invalid_argument, "robot description, line N: <what>".
UrdfText readUrdfText(const std::string& urdf_xml, GeometryKind kind);

}  // namespace deformable_contact_monitor
