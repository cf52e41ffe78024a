// Adapters that convert messages of other types to DeformableMesh.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>
#include <shape_msgs/Mesh.h>
#include <visualization_msgs/Marker.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/triangle_mesh.h"
#include "monitor/input/incoming_mesh.h"

namespace deformable_contact_monitor {

// An adapter serves one topic: it converts the topic's messages in their order, one thread at a
// time. A mesh has triangles only if they differ from those of the last mesh, and topology_id
// changes iff they do, as a publisher of DeformableMesh may do. So no mesh may be lost without
// MeshInput having seen it. A coordinate is the float32 nearest to the message's double; beyond
// float32's range it is an infinity.
//
// adapt() throws std::invalid_argument if the message is not a valid mesh. The adapter is then
// unchanged. `received` is the time of receipt; zero:
// there is no clock. The result has no `arrival`.

// How long [s] an object that was deleted keeps its last mesh: many publishers delete a marker
// before they draw it anew. No mesh within this time means that the object has none.
constexpr double kDeletionGraceS = 0.2;

// Converts shape_msgs/Mesh. That type has neither stamp nor frame: the stamp is the time of
// receipt, and the frame is the configured one.
class ShapeMeshAdapter {
 public:
  using Message = shape_msgs::Mesh;

  explicit ShapeMeshAdapter(std::string frame_id) : frame_id_(std::move(frame_id)) {}

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  bool isSameTopology(const Message& message) const;

  std::string frame_id_;
  std::vector<std::uint32_t> triangles_;  // of the last mesh
  std::size_t vertex_count_ = 0;
  std::uint32_t topology_id_ = 0;
};

// Converts a TRIANGLE_LIST marker to separate triangles: triangle i has the points 3i to 3i + 2. A
// point p becomes float32(R (scale * p) + t) with the marker's pose (R, t), computed in double in
// the order that core/rigid_transform.h gives. An identity pose with scale 1 leaves points
// untouched. An orientation of zeros counts as none, as in rviz. A stamp of zero is replaced by the
// time of receipt.
//
// The topic's first marker (namespace and id) is the object until it is deleted. Other markers are
// rejected. The message that deletes it becomes a mesh without vertices that is_deletion, with the
// reason as its problem, and the adapter forgets the marker.
class MarkerAdapter {
 public:
  using Message = visualization_msgs::Marker;

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  void checkIdentity(const Message& message) const;

  std::optional<std::pair<std::string, std::int32_t>> marker_;  // the object's namespace and id
  std::size_t point_count_ = 0;                                 // of the last mesh
};

// Converts a point cloud whose points are the vertices of a known mesh, row by row, in the order of
// the mesh's file. Coordinates may be float32 or float64, with any layout.
class PointCloudAdapter {
 public:
  using Message = sensor_msgs::PointCloud2;

  // `faces` has the triangles, which the cloud lacks; of its vertices only the number matters.
  explicit PointCloudAdapter(std::shared_ptr<const TriangleMesh> faces)
      : faces_(std::move(faces)) {}

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  std::shared_ptr<const TriangleMesh> faces_;
  bool has_sent_triangles_ = false;
};

}  // namespace deformable_contact_monitor
