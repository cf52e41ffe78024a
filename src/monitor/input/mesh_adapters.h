// Messages of other types as meshes: what each becomes, and why one is refused.
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

namespace deformable_contact_monitor {

struct ReceivedMesh {
  DeformableMesh::ConstPtr message;  // never null; of a refused one, its stamp alone
  std::string refusal{};             // why it is no mesh; empty: it is one
  bool stamped_on_receipt = false;   // the message had no stamp of its own
  double waited_s = 0;               // from its receipt: in a queue, and while it was read
};

// An adapter serves one topic, in the order of its messages, one thread at a time. Its meshes have
// triangles where those are others than the last one's, as a publisher's of DeformableMesh may, so
// none of them may be lost unseen; topology_id changes iff they do. A coordinate is the nearest
// float32 of its double, beyond float32's range an infinity. adapt() throws std::invalid_argument
// if the message is no mesh, and forgets by that no more than a marker that is deleted; `received`
// is the time of its receipt, zero: there is no clock.

// shape_msgs/Mesh has neither stamp nor frame: it has those of its receipt and of the
// configuration.
class ShapeMeshAdapter {
 public:
  using Message = shape_msgs::Mesh;

  explicit ShapeMeshAdapter(std::string frame_id) : frame_id_(std::move(frame_id)) {}

  ReceivedMesh adapt(const Message& message, const ros::Time& received);

 private:
  bool isSameTopology(const Message& message) const;

  std::string frame_id_;
  std::vector<std::uint32_t> triangles_;  // the last ones
  std::size_t vertex_count_ = 0;
  std::uint32_t topology_id_ = 0;
};

// A TRIANGLE_LIST as a soup: triangle i has points 3i to 3i + 2, at float32(R (scale * p) + t) of
// the marker's pose, in double, in the order of core's posed vertices; a pose and scale that change
// nothing leave points untouched. An orientation of zeros is none, as in rviz. A stamp of zero is
// the time of receipt. The topic's first marker (namespace and id) is the object until it is
// deleted: others are refused, and so is what deletes it.
class MarkerAdapter {
 public:
  using Message = visualization_msgs::Marker;

  ReceivedMesh adapt(const Message& message, const ros::Time& received);

 private:
  void checkIdentity(const Message& message);

  std::optional<std::pair<std::string, std::int32_t>> marker_;  // namespace and id of the object
  std::size_t point_count_ = 0;                                 // of the last mesh
};

// A cloud whose points are the vertices of a mesh, row by row, in the order of the mesh's file.
class PointCloudAdapter {
 public:
  using Message = sensor_msgs::PointCloud2;

  // `faces`: what the cloud does not have; of its vertices the number alone matters.
  explicit PointCloudAdapter(std::shared_ptr<const TriangleMesh> faces)
      : faces_(std::move(faces)) {}

  ReceivedMesh adapt(const Message& message, const ros::Time& received);

 private:
  std::shared_ptr<const TriangleMesh> faces_;
  bool has_sent_triangles_ = false;
};

}  // namespace deformable_contact_monitor
