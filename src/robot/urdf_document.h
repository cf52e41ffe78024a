// A URDF's links in document order, their geometry as urdfdom reads it.
#pragma once

#include <urdf_model/link.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

struct UrdfElement {
  Eigen::Affine3d origin = Eigen::Affine3d::Identity();  // link from geometry [m]
  urdf::GeometrySharedPtr geometry;                      // never null
};

struct UrdfLink {
  std::string name;
  std::vector<UrdfElement> elements;  // document order
  std::string problem;                // why the elements could not be read; empty: they could
};

struct UrdfDocument {
  std::string name;
  std::string root_link;
  std::vector<UrdfLink> links;  // document order
};

// Throws std::invalid_argument, naming element and line where there is one, if the document is not
// a robot. A link whose elements are malformed has a problem, and the others go on. Nothing is
// printed. Any thread, but it waits for other callers, and takes console_bridge's handler
// meanwhile.
UrdfDocument readUrdf(const std::string& urdf_xml, GeometryKind kind);

}  // namespace deformable_contact_monitor
