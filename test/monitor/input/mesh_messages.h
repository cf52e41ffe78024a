// Helpers that convert a mesh to a message of each type, and a message to its bytes.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <geometry_msgs/PoseArray.h>
#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/PointField.h>
#include <shape_msgs/Mesh.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"
#include "monitor/input/optional_messages.h"
#include "monitor/rules/tetrahedra.h"

namespace deformable_contact_monitor {

inline const ros::Time kSent(50.25);

template <typename M>
std::vector<std::uint8_t> serialized(const M& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

inline geometry_msgs::Point pointOf(const TriangleMesh& mesh, std::size_t vertex) {
  geometry_msgs::Point point;
  point.x = mesh.vertices[3 * vertex];
  point.y = mesh.vertices[3 * vertex + 1];
  point.z = mesh.vertices[3 * vertex + 2];
  return point;
}

inline PointTriangles trianglesOf(const TriangleMesh& mesh) {
  return {mesh.vertexCount(), {mesh.triangles.begin(), mesh.triangles.end()}};
}

inline DeformableMesh asDeformableMesh(const TriangleMesh& mesh) {
  DeformableMesh message;
  message.header.stamp = kSent;
  message.header.frame_id = "camera";
  message.topology_id = 7;
  message.vertices = mesh.vertices;
  message.triangles = mesh.triangles;
  return message;
}

inline shape_msgs::Mesh asShapeMesh(const TriangleMesh& mesh) {
  shape_msgs::Mesh message;
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) message.vertices.push_back(pointOf(mesh, i));
  message.triangles.resize(mesh.triangleCount());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    message.triangles[i / 3].vertex_indices[i % 3] = mesh.triangles[i];
  }
  return message;
}

inline visualization_msgs::Marker asMarker(const TriangleMesh& mesh) {
  visualization_msgs::Marker message;
  message.header.stamp = kSent;
  message.header.frame_id = "camera";
  message.ns = "cloth";
  message.type = visualization_msgs::Marker::TRIANGLE_LIST;
  message.scale.x = message.scale.y = message.scale.z = 1;
  for (const std::uint32_t corner : mesh.triangles) message.points.push_back(pointOf(mesh, corner));
  return message;
}

// The marker 'cloth'/2 behind two others, as cloth simulators publish points, lines and triangles.
inline visualization_msgs::MarkerArray asMarkerArray(const TriangleMesh& mesh) {
  visualization_msgs::MarkerArray message;
  message.markers.assign(3, asMarker(mesh));
  for (std::int32_t id = 0; id < 3; ++id) message.markers[id].id = id;
  message.markers[0].type = visualization_msgs::Marker::POINTS;
  message.markers[1].type = visualization_msgs::Marker::LINE_LIST;
  message.markers[1].points.clear();
  return message;
}

// The mesh's vertices as a line, here and below.
inline visualization_msgs::Marker asLineStrip(const TriangleMesh& mesh) {
  visualization_msgs::Marker message = asMarker({mesh.vertices, {}});
  message.type = visualization_msgs::Marker::LINE_STRIP;
  message.scale.x = 0.25;  // its width
  message.scale.y = message.scale.z = 0;
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) message.points.push_back(pointOf(mesh, i));
  return message;
}

inline geometry_msgs::PoseArray asPoseArray(const TriangleMesh& mesh) {
  geometry_msgs::PoseArray message;
  message.header.stamp = kSent;
  message.header.frame_id = "camera";
  message.poses.resize(mesh.vertexCount());
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) message.poses[i].position = pointOf(mesh, i);
  return message;
}

#ifdef DCM_HAS_NAV_MSGS
inline nav_msgs::Path asPath(const TriangleMesh& mesh) {
  nav_msgs::Path message;
  message.header.stamp = kSent;
  message.header.frame_id = "camera";
  message.poses.resize(mesh.vertexCount());
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) {
    message.poses[i].pose.position = pointOf(mesh, i);
    message.poses[i].header.stamp = ros::Time(static_cast<double>(i));
    if (i % 2 == 0) message.poses[i].header.frame_id = "camera";
  }
  return message;
}
#endif

// The layout of a cloud's bytes.
struct CloudLayout {
  std::uint32_t offsets[3] = {0, 4, 8};
  bool is_double[3] = {false, false, false};
  std::uint32_t point_step = 12, row_padding = 0, height = 1;
};

// `layout.height` must divide the vertices.
inline sensor_msgs::PointCloud2 asPointCloud(const TriangleMesh& mesh,
                                             const CloudLayout& layout = {}) {
  sensor_msgs::PointCloud2 message;
  message.header.stamp = kSent;
  message.header.frame_id = "camera";
  message.height = layout.height;
  message.width = static_cast<std::uint32_t>(mesh.vertexCount() / layout.height);
  message.point_step = layout.point_step;
  message.row_step = message.width * layout.point_step + layout.row_padding;
  message.data.assign(std::size_t{message.row_step} * message.height, 0xAB);
  for (int axis = 0; axis < 3; ++axis) {
    sensor_msgs::PointField field;
    field.name = std::string(1, "xyz"[axis]);
    field.offset = layout.offsets[axis];
    field.datatype = layout.is_double[axis] ? sensor_msgs::PointField::FLOAT64
                                            : sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    message.fields.push_back(field);
  }
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint8_t* const at = message.data.data() + i / message.width * message.row_step +
                               i % message.width * message.point_step + layout.offsets[axis];
      const float value = mesh.vertices[3 * i + axis];
      const double as_double = value;
      if (layout.is_double[axis]) {
        std::memcpy(at, &as_double, sizeof as_double);
      } else {
        std::memcpy(at, &value, sizeof value);
      }
    }
  }
  return message;
}

#ifdef DCM_HAS_PCL_MSGS
inline pcl_msgs::PolygonMesh asPolygonMesh(const TriangleMesh& mesh) {
  pcl_msgs::PolygonMesh message;
  message.cloud = asPointCloud(mesh);
  message.header = message.cloud.header;
  message.polygons.resize(mesh.triangleCount());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    message.polygons[i / 3].vertices.push_back(mesh.triangles[i]);
  }
  return message;
}
#endif

}  // namespace deformable_contact_monitor
