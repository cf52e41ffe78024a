// Robot description to one triangle mesh per link.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"
#include "robot/link_mesh_file.h"
#include "robot/srdf.h"

namespace deformable_contact_monitor {

enum class GeometryKind { kCollision, kVisual };

struct LinkGeometry {
  std::string link;
  std::string source;   // the files and primitives it came from, for people
  TriangleMesh mesh;    // [m], in the link's frame; origins and scales applied
  std::string problem;  // why the link has no usable geometry; empty: it has
};

struct RobotGeometry {
  std::string name;
  std::string root_link;            // empty where there is no URDF
  std::vector<LinkGeometry> links;  // document order; links without geometry do not appear
  // Of all links that there are: those that the options leave out, and those without geometry, too.
  std::set<std::string> link_names;
  Srdf srdf;  // which links may touch each other; without rules unless somebody fills it
};

struct RobotGeometryOptions {
  GeometryKind kind = GeometryKind::kCollision;
  std::vector<std::string> links;          // only these; empty: all
  std::vector<std::string> ignored_links;  // never these
};

// Turns a mesh URI (package://, file://, a plain path) into a local path; throws
// std::runtime_error saying what was looked for and where.
using ResourceResolver = std::function<std::string(const std::string& uri)>;

// Resolves package:// through rospack, and file:// and absolute paths directly.
ResourceResolver makeRosResolver();

// Every link's collision (or visual) elements as triangles: meshes (STL, DAE, OBJ) and primitives.
// A link whose mesh cannot be had keeps its place, with `problem` set and an empty mesh, so that
// one file that is missing or does harm costs nobody else's data. Triangles are in the order of the
// elements and, within an STL, of its file; equal vertices are stored once. Throws
// std::invalid_argument, naming element and line where there is one, if the URDF itself is
// malformed, or a name in the options is no link; and ReadingStopped. It takes little more than
// reading.robot_time at most.
RobotGeometry loadRobotGeometry(const std::string& urdf_xml, const RobotGeometryOptions& options,
                                const ResourceResolver& resolve, const MeshReading& reading = {});

// The longest side of the box around its finite vertices; 0: it has none.
double linkLengthM(const LinkGeometry& link);

// One line for each fact about a usable link that its owner should know: longer than 10 m or
// shorter than 1 mm, more than 200 000 triangles, vertices that are not finite.
std::vector<std::string> geometryWarnings(const RobotGeometry& robot);

}  // namespace deformable_contact_monitor
