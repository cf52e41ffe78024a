// Converts pcl_msgs/PolygonMesh to DeformableMesh, if pcl_msgs is there.
#include "monitor/input/polygon_mesh_adapter.h"

#ifdef DCM_HAS_PCL_MSGS

#include <boost/make_shared.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "monitor/input/cloud_points.h"

namespace deformable_contact_monitor {
namespace {

// Checks all polygons before memory is taken for their triangles, and returns the number of those.
std::size_t triangleCount(const std::vector<pcl_msgs::Vertices>& polygons) {
  if (polygons.empty()) throw std::invalid_argument("the mesh has no polygon");
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    const std::size_t corners = polygons[i].vertices.size();
    if (corners < 3) {
      throw std::invalid_argument("polygon " + std::to_string(i) + " has " +
                                  std::to_string(corners) + " vertices, must have at least 3");
    }
    triangles += corners - 2;
  }
  return triangles;
}

std::vector<std::uint32_t> fansOf(const std::vector<pcl_msgs::Vertices>& polygons) {
  std::vector<std::uint32_t> triangles;
  triangles.reserve(3 * triangleCount(polygons));
  for (const pcl_msgs::Vertices& polygon : polygons) {
    const std::vector<std::uint32_t>& corners = polygon.vertices;
    for (std::size_t i = 2; i < corners.size(); ++i) {
      triangles.insert(triangles.end(), {corners[0], corners[i - 1], corners[i]});
    }
  }
  return triangles;
}

}  // namespace

IncomingMesh PolygonMeshAdapter::adapt(const Message& message, const ros::Time& /*received*/) {
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  CloudPoints(message.cloud).appendTo(&mesh->vertices);
  std::vector<std::uint32_t> triangles = fansOf(message.polygons);
  if (triangles != triangles_ || mesh->vertices.size() != coordinate_count_) {
    triangles_ = triangles;
    coordinate_count_ = mesh->vertices.size();
    mesh->triangles = std::move(triangles);
    ++topology_id_;
  }
  mesh->topology_id = topology_id_;
  return {mesh};
}

}  // namespace deformable_contact_monitor

#endif
