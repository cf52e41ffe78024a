// Loads one triangle mesh for each link of a robot, from its URDF.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"
#include "robot/link_mesh_files.h"
#include "robot/robot_joint.h"
#include "robot/srdf.h"
#include "robot/urdf_document.h"

namespace deformable_contact_monitor {

// The triangles of one link, or the reason why there are none.
struct LinkGeometry {
  std::string link;
  std::string source;   // the files and primitives it came from, for people
  TriangleMesh mesh;    // [m], in the link's frame; origins and scales applied
  std::string problem;  // why the link has no usable geometry; empty: it has
  // Each note names a mesh file and what in it may not be meant as it was read.
  std::vector<std::string> notes = {};
};

// One of the robots whose links are monitored. The names of links have the robot's prefix.
struct DescribedRobot {
  std::string name;             // as its URDF says; empty where there is no URDF
  std::set<std::string> links;  // all of its links
  Srdf srdf;                    // which of them may touch each other

  bool operator==(const DescribedRobot& other) const;
};

// The geometry of all links of a robot, or of several robots, and the rules of their SRDFs.
struct RobotGeometry {
  std::string root_link;            // of the first robot; empty where there is no URDF
  std::vector<LinkGeometry> links;  // document order; links without geometry do not appear
  // The names of all links, also of those that the options leave out and those without geometry.
  std::set<std::string> link_names;
  // Links that the options select, but that have only geometry of the other kind: visual where
  // `kind` is collision, and the reverse. They are not among `links`.
  std::vector<std::string> unmonitored_links;
  GeometryKind kind = GeometryKind::kCollision;
  std::vector<DescribedRobot> robots;
  std::vector<RobotJoint> joints{};  // of all robots; empty where there is no URDF
};

// Selects which geometry of which links is loaded.
struct RobotGeometryOptions {
  GeometryKind kind = GeometryKind::kCollision;
  std::vector<std::string> links;          // only these; empty: all
  std::vector<std::string> ignored_links;  // never these
};

// A robot to load: its description, and what precedes the names of its links.
struct RobotDescription {
  std::string urdf_xml;
  std::string source;  // where the URDF comes from; begins messages unless it is empty
  std::string link_prefix;
  Srdf srdf;  // its names have no prefix yet
};

// Loads every link's collision (or visual) elements as triangles: meshes (STL, DAE, OBJ, PLY, OFF)
// and primitives. A link whose mesh cannot be loaded keeps its place, with `problem` set and an
// empty mesh, so that a missing or harmful file affects no other link. Triangles are in the order
// of the elements and, within an STL, of its file; equal vertices are stored once. Takes little
// more than reading.robot_time at most. Throws std::invalid_argument, naming element and line where
// there is one, if the URDF itself is malformed, a name in the options is no link, or two links
// have one name; and ReadingStopped. The names in the options have their prefix.
RobotGeometry loadRobots(const std::vector<RobotDescription>& robots,
                         const RobotGeometryOptions& options, const ResourceResolver& resolve,
                         const MeshReading& reading = {});

// Loads a single robot whose links have no prefix, without an SRDF.
RobotGeometry loadRobotGeometry(const std::string& urdf_xml, const RobotGeometryOptions& options,
                                const ResourceResolver& resolve, const MeshReading& reading = {});

// Returns the longest side of the box around the link's finite vertices [m]; 0 if it has none.
double linkLengthM(const LinkGeometry& link);

// Returns one line for each fact about a robot that its owner should know: joints that form a loop
// or give a link several parents, or mimic what is no joint; links that are not monitored because
// their geometry is of the other kind; and usable links that are longer than 10 m or shorter than 1
// mm, have more than 200 000 triangles or vertices that are not finite, or whose files have
// something unusual.
std::vector<std::string> geometryWarnings(const RobotGeometry& robot);

}  // namespace deformable_contact_monitor
