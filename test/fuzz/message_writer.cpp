// Well-formed messages of meshes, of more or less sense, as bytes.
#include "message_writer.h"

#include <deformable_contact_monitor/DeformableMesh.h>
#include <geometry_msgs/PoseArray.h>
#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/PointField.h>
#include <shape_msgs/Mesh.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "monitor/input/optional_messages.h"

namespace deformable_contact_monitor {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <typename M>
Bytes serialized(const M& message) {
  Bytes bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

std_msgs::Header headerFrom(ByteSource* source, const ros::Time& stamp) {
  constexpr const char* kFrames[] = {"base_link", "camera", "/camera", "nowhere", ""};
  std_msgs::Header header;
  header.stamp = source->below(16) == 15 ? ros::Time() : stamp;
  header.frame_id = kFrames[source->below(5)];
  return header;
}

template <typename Xyz>
void readXyz(ByteSource* source, Xyz* to) {
  to->x = source->coordinate();
  to->y = source->coordinate();
  to->z = source->coordinate();
}

DeformableMesh deformableMeshFrom(ByteSource* source, const ros::Time& stamp) {
  constexpr const char* kObjects[] = {"cloth", "", "cloth", "towel"};
  DeformableMesh message;
  message.header = headerFrom(source, stamp);
  message.object = kObjects[source->below(4)];
  message.topology_id = static_cast<std::uint32_t>(source->below(3));
  message.vertices.resize(source->below(40));
  for (float& coordinate : message.vertices) coordinate = source->coordinate();
  message.triangles.resize(source->below(40));
  for (std::uint32_t& index : message.triangles) index = source->byte() % 14;
  return message;
}

shape_msgs::Mesh shapeMeshFrom(ByteSource* source) {
  shape_msgs::Mesh message;
  message.vertices.resize(source->below(14));
  for (geometry_msgs::Point& point : message.vertices) readXyz(source, &point);
  message.triangles.resize(source->below(14));
  for (shape_msgs::MeshTriangle& triangle : message.triangles) {
    for (std::uint32_t& index : triangle.vertex_indices) index = source->byte() % 14;
  }
  return message;
}

visualization_msgs::Marker markerFrom(ByteSource* source, const ros::Time& stamp,
                                      int type = visualization_msgs::Marker::TRIANGLE_LIST) {
  visualization_msgs::Marker message;
  message.header = headerFrom(source, stamp);
  message.id = source->below(16) == 15 ? 1 : 0;
  message.type = source->below(16) == 15 ? source->byte() : type;
  message.action = source->below(16) == 15 ? source->byte() % 4 : int{message.ADD};
  message.scale.x = message.scale.y = message.scale.z = 1;
  if (source->flag()) readXyz(source, &message.scale);
  if (source->flag()) readXyz(source, &message.pose.position);
  if (source->flag()) message.pose.orientation.x = source->coordinate();
  if (source->flag()) message.pose.orientation.w = 1;
  message.points.resize(3 * source->below(14) + (source->below(16) == 15 ? 1 : 0));
  for (geometry_msgs::Point& point : message.points) readXyz(source, &point);
  return message;
}

visualization_msgs::MarkerArray markerArrayFrom(ByteSource* source, const ros::Time& stamp) {
  visualization_msgs::MarkerArray message;
  message.markers.resize(source->below(4));
  for (visualization_msgs::Marker& marker : message.markers) marker = markerFrom(source, stamp);
  return message;
}

geometry_msgs::PoseArray poseArrayFrom(ByteSource* source, const ros::Time& stamp) {
  geometry_msgs::PoseArray message;
  message.header = headerFrom(source, stamp);
  message.poses.resize(source->below(14));
  for (geometry_msgs::Pose& pose : message.poses) readXyz(source, &pose.position);
  return message;
}

#ifdef DCM_HAS_NAV_MSGS
nav_msgs::Path pathFrom(ByteSource* source, const ros::Time& stamp) {
  nav_msgs::Path message;
  message.header = headerFrom(source, stamp);
  message.poses.resize(source->below(14));
  for (geometry_msgs::PoseStamped& pose : message.poses) {
    if (source->flag()) pose.header = headerFrom(source, stamp);
    readXyz(source, &pose.pose.position);
  }
  return message;
}
#endif

sensor_msgs::PointCloud2 pointCloudFrom(ByteSource* source, const ros::Time& stamp,
                                        std::size_t count) {
  constexpr const char* kNames[] = {"x", "y", "z"};
  sensor_msgs::PointCloud2 message;
  message.header = headerFrom(source, stamp);
  message.height = source->flag() ? 1 : 2;
  message.width = static_cast<std::uint32_t>(count / message.height);
  for (const char* const name : kNames) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = message.point_step + source->byte() % 4;
    field.datatype = source->flag() ? field.FLOAT32 : field.FLOAT64;
    field.count = 1;
    message.point_step = field.offset + (field.datatype == field.FLOAT32 ? 4 : 8);
    message.fields.push_back(field);
  }
  message.row_step = message.point_step * message.width + source->byte() % 4;
  message.data = source->bytes(std::size_t{message.row_step} * message.height);
  message.data.resize(std::size_t{message.row_step} * message.height);
  std::uint32_t* const numbers[] = {
      &message.width,      &message.height,           &message.row_step,
      &message.point_step, &message.fields[0].offset, &message.fields[2].count};
  if (source->below(4) == 3) *numbers[source->below(6)] = source->number<std::uint32_t>();
  return message;
}

#ifdef DCM_HAS_PCL_MSGS
pcl_msgs::PolygonMesh polygonMeshFrom(ByteSource* source, const ros::Time& stamp) {
  pcl_msgs::PolygonMesh message;
  message.header = headerFrom(source, stamp);
  message.polygons.resize(source->below(8));
  for (pcl_msgs::Vertices& polygon : message.polygons) {
    polygon.vertices.resize(source->below(6));
    for (std::uint32_t& index : polygon.vertices) index = source->byte() % 5;
  }
  message.cloud = pointCloudFrom(source, stamp, fuzzedFaces().point_count);
  return message;
}
#endif

template <typename M>
Bytes bytesAs(const boost::shared_ptr<const void>& message) {
  return serialized(*static_cast<const M*>(message.get()));
}

}  // namespace

PointTriangles fuzzedFaces() { return {4, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}}; }

Bytes messageBytes(MeshType type, ByteSource* source, const ros::Time& stamp) {
  switch (type) {
    case MeshType::kShapeMesh:
      return serialized(shapeMeshFrom(source));
    case MeshType::kMarker:
      return serialized(markerFrom(source, stamp));
    case MeshType::kMarkerArray:
      return serialized(markerArrayFrom(source, stamp));
    case MeshType::kPointCloud:
    case MeshType::kTetrahedra:
      return serialized(pointCloudFrom(source, stamp, fuzzedFaces().point_count));
    case MeshType::kPoints:
    case MeshType::kPolyline:
      return serialized(pointCloudFrom(source, stamp, source->below(14)));
    case MeshType::kPolylinePoses:
      return serialized(poseArrayFrom(source, stamp));
    case MeshType::kPolylineMarker:
      return serialized(markerFrom(source, stamp, visualization_msgs::Marker::LINE_STRIP));
#ifdef DCM_HAS_NAV_MSGS
    case MeshType::kPolylinePath:
      return serialized(pathFrom(source, stamp));
#endif
#ifdef DCM_HAS_PCL_MSGS
    case MeshType::kPolygonMesh:
      return serialized(polygonMeshFrom(source, stamp));
#endif
    default:
      return serialized(deformableMeshFrom(source, stamp));
  }
}

Bytes bytesOf(MeshType type, const boost::shared_ptr<const void>& message) {
  switch (type) {
    case MeshType::kShapeMesh:
      return bytesAs<shape_msgs::Mesh>(message);
    case MeshType::kMarker:
    case MeshType::kPolylineMarker:
      return bytesAs<visualization_msgs::Marker>(message);
    case MeshType::kMarkerArray:
      return bytesAs<visualization_msgs::MarkerArray>(message);
    case MeshType::kPointCloud:
    case MeshType::kTetrahedra:
    case MeshType::kPoints:
    case MeshType::kPolyline:
      return bytesAs<sensor_msgs::PointCloud2>(message);
    case MeshType::kPolylinePoses:
      return bytesAs<geometry_msgs::PoseArray>(message);
#ifdef DCM_HAS_NAV_MSGS
    case MeshType::kPolylinePath:
      return bytesAs<nav_msgs::Path>(message);
#endif
#ifdef DCM_HAS_PCL_MSGS
    case MeshType::kPolygonMesh:
      return bytesAs<pcl_msgs::PolygonMesh>(message);
#endif
    default:
      return bytesAs<DeformableMesh>(message);
  }
}

}  // namespace deformable_contact_monitor
