// Reads the parameter `type` of objects.
#include "monitor/rules/object_types.h"

#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "core/mesh_file.h"
#include "monitor/input/optional_messages.h"
#include "robot/link_mesh_files.h"
#include "robot/regular_file.h"

namespace deformable_contact_monitor {
namespace {

void readFrame(ParameterReader* entry, ObjectParameters* object) {
  object->frame_id = entry->text("frame_id", "");
  if (object->frame_id.empty())
    entry->addProblem("frame_id", "is missing: messages of type shape_mesh name no frame");
}

// Without faces the cloud is a depth camera's image.
void readFaces(ParameterReader* entry, ObjectParameters* object) {
  if (!entry->has("faces")) {
    DepthRule& rule = object->depth;
    rule.max_depth_jump = entry->number("max_depth_jump", rule.max_depth_jump, 0, 1);
    rule.min_seen = entry->number("min_seen", rule.min_seen, 0, 1);
    if (entry->has("parts")) {
      entry->addProblem("parts",
                        "are not supported for a point_cloud without faces, because its "
                        "triangles are others in each message");
    }
    return;
  }
  const std::string faces = entry->text("faces", "");
  if (faces.empty()) return;
  try {
    const TriangleMesh mesh = readMeshFile(makeRosResolver()(faces));
    PointTriangles triangles{mesh.vertexCount(), {mesh.triangles.begin(), mesh.triangles.end()}};
    object->faces = std::make_shared<const PointTriangles>(std::move(triangles));
  } catch (const std::exception& error) {
    entry->addProblem("faces", "is '" + faces + "': " + error.what());
  }
}

void readCellsFile(ParameterReader* entry, ObjectParameters* object) {
  const std::string cells = entry->text("cells", "");
  if (cells.empty()) {
    return entry->addProblem("cells",
                             "is missing: give the file with the four points of each cell");
  }
  try {
    const std::vector<Cell> all = readCells(readRegularFile(makeRosResolver()(cells)));
    object->faces = std::make_shared<const PointTriangles>(surfaceOf(all));
  } catch (const std::exception& error) {
    entry->addProblem("cells", "is '" + cells + "': " + error.what());
  }
}

void readMarker(ParameterReader* entry, std::vector<std::string>* warnings,
                ObjectParameters* object) {
  using Limits = std::numeric_limits<int>;
  std::optional<ParameterReader> section = entry->section("marker");
  if (!section || !section->has("id")) {
    entry->addProblem("marker", "is missing: give the marker's name, such as {ns: cloth, id: 2}");
    return;
  }
  object->marker = {section->optionalText("ns", ""),
                    section->integer("id", 0, Limits::min(), Limits::max())};
  section->warnOfUnknown(warnings);
}

// Without a radius nearly nothing touches points or lines, so nobody shall forget it.
void requireRadius(ParameterReader* entry) {
  if (entry->has("radius_m")) return;
  entry->addProblem("radius_m",
                    "is missing: points and polylines have no thickness of their own; "
                    "give their radius, or 0");
}

// The choices stand in the order of MeshType.
void readLineMessage(ParameterReader* entry, ObjectParameters* object) {
  const std::size_t message =
      entry->choice("message", {"point_cloud", "pose_array", "path", "marker"}, 0);
  object->type = static_cast<MeshType>(static_cast<std::size_t>(MeshType::kPolyline) + message);
#ifndef DCM_HAS_NAV_MSGS
  if (object->type == MeshType::kPolylinePath) {
    entry->addProblem("message",
                      "is 'path', but the package nav_msgs was not there when this program was "
                      "built");
  }
#endif
}

}  // namespace

bool isRigid(ParameterReader* entry) { return entry->optionalText("type", "") == "rigid"; }

// The choices stand in the order of MeshType. isRigid() has taken the last one.
void readObjectType(ParameterReader* entry, std::vector<std::string>* warnings,
                    ObjectParameters* object) {
  object->type = static_cast<MeshType>(
      entry->choice("type",
                    {"deformable_mesh", "shape_mesh", "marker", "point_cloud", "marker_array",
                     "tetrahedra", "polygon_mesh", "points", "polyline", "rigid"},
                    0));
#ifndef DCM_HAS_PCL_MSGS
  if (object->type == MeshType::kPolygonMesh) {
    entry->addProblem("type",
                      "is 'polygon_mesh', but the package pcl_msgs was not there when this "
                      "program was built");
  }
#endif
  if (object->type == MeshType::kShapeMesh) readFrame(entry, object);
  if (object->type == MeshType::kPointCloud) readFaces(entry, object);
  if (object->type == MeshType::kTetrahedra) readCellsFile(entry, object);
  if (object->type == MeshType::kMarkerArray) readMarker(entry, warnings, object);
  if (object->type == MeshType::kPoints || object->type == MeshType::kPolyline) {
    requireRadius(entry);
  }
  if (object->type == MeshType::kPolyline) readLineMessage(entry, object);
}

}  // namespace deformable_contact_monitor
