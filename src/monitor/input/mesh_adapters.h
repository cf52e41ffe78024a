// Adapters that convert messages of other types to DeformableMesh.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <geometry_msgs/PoseArray.h>
#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>
#include <shape_msgs/Mesh.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "monitor/input/incoming_mesh.h"
#include "monitor/input/optional_messages.h"
#include "monitor/rules/parameters.h"

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

// Returns the stamp plus the offset [s]; zero if the stamp is zero, or ros::Time cannot hold the
// sum.
ros::Time correctedStamp(const ros::Time& stamp, double offset_s);

// Corrects the stamp of a mesh by its object's stamp_offset_s. A mesh without a stamp stays so. One
// whose corrected stamp ros::Time cannot hold becomes invalid.
void correctStamp(double offset_s, IncomingMesh* mesh);

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

// What a sequence of points means. Triangle i has the points 3i to 3i + 2 of kTriangles, (i, i + 1,
// i + 1) of kLine, and (i, i, i) of kSeparate. A line of a single point is that point.
enum class PointShape { kTriangles, kLine, kSeparate };

// Returns the triangles between `count` points.
std::vector<std::uint32_t> trianglesBetween(PointShape shape, std::size_t count);

// Converts a TRIANGLE_LIST marker to separate triangles (kTriangles), or a LINE_STRIP to a line. A
// point p becomes float32(R (scale * p) + t) with the marker's pose (R, t), computed in double in
// the order that core/rigid_transform.h gives. The scale of a line is the width that rviz draws,
// and does not move its points. An identity pose with scale 1 leaves points untouched. An
// orientation of zeros counts as none, as in rviz. A stamp of zero is replaced by the time of
// receipt.
//
// The topic's first marker (namespace and id) is the object until it is deleted. Other markers are
// rejected. The message that deletes it becomes a mesh without vertices that is_deletion, with the
// reason as its problem, and the adapter forgets the marker.
class MarkerAdapter {
 public:
  using Message = visualization_msgs::Marker;

  // `shape` is kTriangles or kLine.
  explicit MarkerAdapter(PointShape shape = PointShape::kTriangles) : shape_(shape) {}

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  void checkIdentity(const Message& message) const;

  const PointShape shape_;
  std::optional<MarkerName> marker_;  // the object's
  std::size_t point_count_ = 0;       // of the last mesh
};

// Returns whether a marker's message deletes it, or all markers.
inline bool isDeletion(const visualization_msgs::Marker& marker) {
  using visualization_msgs::Marker;
  return marker.action == Marker::DELETE || marker.action == Marker::DELETEALL;
}

// Returns what an array says about one marker: the last of its markers that has this name, or that
// deletes all markers. Null: there is none.
const visualization_msgs::Marker* markerOf(const visualization_msgs::MarkerArray& message,
                                           const MarkerName& name);

// Converts one marker of a MarkerArray, as MarkerAdapter does; the other markers are not looked at.
// Of several messages about it in one array the last one counts. An array without it becomes an
// IncomingMesh without a message. If no array so far had it, an array without it is rejected with
// the names that are there.
class MarkerArrayAdapter {
 public:
  using Message = visualization_msgs::MarkerArray;

  explicit MarkerArrayAdapter(MarkerName name) : name_(std::move(name)) {}

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  const MarkerName name_;
  bool is_seen_ = false;         // some array had the marker
  std::size_t point_count_ = 0;  // of the last mesh
};

// Converts a point cloud whose points are the vertices of a known mesh, row by row, in the order of
// the mesh's file, or the corners of known tetrahedra. Coordinates may be float32 or float64, with
// any layout.
class PointCloudAdapter {
 public:
  using Message = sensor_msgs::PointCloud2;

  // `faces` are the triangles, which the cloud lacks.
  explicit PointCloudAdapter(std::shared_ptr<const PointTriangles> faces)
      : faces_(std::move(faces)) {}

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  std::shared_ptr<const PointTriangles> faces_;
  bool has_sent_triangles_ = false;
};

// The triangles of a topic whose messages may have others each time.
class ChangingTopology {
 public:
  // Gives a mesh, whose vertices are there, its topology_id, and the triangles unless they are
  // those of the last mesh.
  void addTo(std::vector<std::uint32_t> triangles, DeformableMesh* mesh);

 private:
  std::vector<std::uint32_t> triangles_;  // of the last mesh
  std::size_t coordinate_count_ = 0;      // of the last mesh
  std::uint32_t topology_id_ = 0;
};

// Converts an organised point cloud, as a depth camera sends it: the points are the pixels, row by
// row, and depthSurface() makes the triangles. They are mostly others in each message. A cloud in
// which too few pixels have a depth is rejected, so that a covered camera does not look like a free
// space.
class DepthCloudAdapter {
 public:
  using Message = sensor_msgs::PointCloud2;

  explicit DepthCloudAdapter(const DepthRule& rule) : rule_(rule) {}

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  const DepthRule rule_;
  ChangingTopology topology_;
};

#ifdef DCM_HAS_PCL_MSGS
// Converts pcl_msgs/PolygonMesh, if pcl_msgs is there. The points of the cloud are the vertices,
// and a polygon (p0, p1, p2, ...) becomes the triangles (p0, p1, p2), (p0, p2, p3), ... Stamp and
// frame are those of the message's own header, not of its cloud.
class PolygonMeshAdapter {
 public:
  using Message = pcl_msgs::PolygonMesh;

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  ChangingTopology topology_;
};
#endif

// Converts a message of at least one point, whose number may change, to a line or to separate
// points. M is PointCloud2, of which the points count row by row, PoseArray, or Path, of which the
// positions count. A Path has the frame and the stamp of its own header, and a pose that names
// another frame is rejected.
template <typename M>
class PointsAdapter {
 public:
  using Message = M;

  // `shape` is kLine or kSeparate.
  explicit PointsAdapter(PointShape shape) : shape_(shape) {}

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  const PointShape shape_;
  std::size_t point_count_ = 0;  // of the last mesh
};

}  // namespace deformable_contact_monitor
