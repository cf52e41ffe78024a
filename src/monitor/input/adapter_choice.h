// Chooses the adapter of an object's messages.
#pragma once

#include "monitor/input/mesh_adapters.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// Returns use(adapter), with a new adapter that converts the messages of this object; otherwise()
// if they are DeformableMesh, which need none. Both must return the same type.
template <typename Use, typename Otherwise>
auto withAdapter(const ObjectParameters& object, const Use& use, const Otherwise& otherwise) {
  using sensor_msgs::PointCloud2;
  switch (object.type) {
    case MeshType::kShapeMesh:
      return use(ShapeMeshAdapter(object.frame_id));
    case MeshType::kMarker:
      return use(MarkerAdapter());
    case MeshType::kPointCloud:
      if (object.faces == nullptr) return use(DepthCloudAdapter(object.depth));
      [[fallthrough]];
    case MeshType::kTetrahedra:
      return use(PointCloudAdapter(object.faces));
    case MeshType::kMarkerArray:
      return use(MarkerArrayAdapter(object.marker));
#ifdef DCM_HAS_PCL_MSGS
    case MeshType::kPolygonMesh:
      return use(PolygonMeshAdapter());
#endif
    case MeshType::kPoints:
      return use(PointsAdapter<PointCloud2>(PointShape::kSeparate));
    case MeshType::kPolyline:
      return use(PointsAdapter<PointCloud2>(PointShape::kLine));
    case MeshType::kPolylinePoses:
      return use(PointsAdapter<geometry_msgs::PoseArray>(PointShape::kLine));
#ifdef DCM_HAS_NAV_MSGS
    case MeshType::kPolylinePath:
      return use(PointsAdapter<nav_msgs::Path>(PointShape::kLine));
#endif
    case MeshType::kPolylineMarker:
      return use(MarkerAdapter(PointShape::kLine));
    default:
      return otherwise();
  }
}

}  // namespace deformable_contact_monitor
