// Adapters that convert messages of other types to DeformableMesh. Every check throws by reject(),
// so a message is either converted as a whole or has no effect.
#include "monitor/input/mesh_adapters.h"

#include <geometry_msgs/Transform.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <stdexcept>

#include "monitor/input/cloud_points.h"
#include "monitor/input/depth_surface.h"
#include "monitor/input/transform_lookup.h"

namespace deformable_contact_monitor {
namespace {

using geometry_msgs::PoseArray;
using sensor_msgs::PointCloud2;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

[[noreturn]] void reject(const std::string& why) { throw std::invalid_argument(why); }

// Returns the stamp of a message that has none of its own.
ros::Time stampOfReceipt(const ros::Time& received) {
  if (received.isZero()) reject("it has no stamp, and /clock is silent: no time of its receipt");
  return received;
}

void append(double x, double y, double z, std::vector<float>* vertices) {
  vertices->push_back(static_cast<float>(x));
  vertices->push_back(static_cast<float>(y));
  vertices->push_back(static_cast<float>(z));
}

MarkerName nameOf(const Marker& marker) { return {marker.ns, marker.id}; }

std::string sizeText(const PointCloud2& cloud) {
  return std::to_string(cloud.width) + " x " + std::to_string(cloud.height);
}

std::string shown(const MarkerName& marker) {
  return "'" + marker.first + "'/" + std::to_string(marker.second);
}

// Returns the names of the array's first markers, for people.
std::string shownNames(const MarkerArray& message) {
  constexpr std::size_t kMost = 4, kMostLetters = 40;
  std::string names;
  for (std::size_t i = 0; i < std::min(kMost, message.markers.size()); ++i) {
    const Marker& marker = message.markers[i];
    names += (i == 0 ? "" : ", ") + shown({marker.ns.substr(0, kMostLetters), marker.id});
  }
  if (message.markers.size() > kMost) names += ", ...";
  return names.empty() ? "is empty" : names;
}

// Returns the invalid mesh that stands for a deletion.
IncomingMesh deletion(const Marker& message) {
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  IncomingMesh deleted{mesh, message.action == Marker::DELETEALL
                                 ? "all markers were deleted (DELETEALL)"
                                 : "marker " + shown(nameOf(message)) + " was deleted"};
  deleted.is_deletion = true;
  return deleted;
}

bool isFinite(double x, double y, double z) {
  return std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
}

// Returns the marker's orientation. tf2 and rviz accept a length that is not quite 1.
geometry_msgs::Quaternion orientationOf(const Marker& marker) {
  constexpr double kTolerance = 1e-2;
  geometry_msgs::Quaternion q = marker.pose.orientation;
  if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0) q.w = 1;
  const double squared = ((q.x * q.x + q.y * q.y) + q.z * q.z) + q.w * q.w;
  if (!(std::abs(squared - 1) <= kTolerance)) {
    reject("pose.orientation is no unit quaternion: its length is " +
           std::to_string(std::sqrt(squared)));
  }
  return q;
}

// Returns what the marker's points are multiplied by.
geometry_msgs::Vector3 scaleOf(const Marker& marker, PointShape shape) {
  geometry_msgs::Vector3 scale = marker.scale;
  if (shape == PointShape::kLine) scale.x = scale.y = scale.z = 1;
  if (!isFinite(scale.x, scale.y, scale.z)) reject("scale is not finite");
  if (scale.x == 0 || scale.y == 0 || scale.z == 0) reject("scale is zero in x, y or z");
  return scale;
}

geometry_msgs::Transform poseOf(const Marker& marker) {
  const geometry_msgs::Point& at = marker.pose.position;
  if (!isFinite(at.x, at.y, at.z)) reject("pose.position is not finite");
  geometry_msgs::Transform pose;
  pose.translation.x = at.x;
  pose.translation.y = at.y;
  pose.translation.z = at.z;
  pose.rotation = orientationOf(marker);
  return pose;
}

// Writes the sums out in their order, so that results do not depend on the compiler.
void appendPosedPoints(const Marker& marker, PointShape shape, std::vector<float>* vertices) {
  const RigidTransform pose = toRigidTransform(poseOf(marker));
  const geometry_msgs::Vector3 scale = scaleOf(marker, shape);
  const bool is_untouched = pose.isIdentity() && scale.x == 1 && scale.y == 1 && scale.z == 1;
  const double* r = pose.rotation;
  const double* t = pose.translation;
  for (const geometry_msgs::Point& point : marker.points) {
    const double x = scale.x * point.x, y = scale.y * point.y, z = scale.z * point.z;
    if (is_untouched) {
      append(x, y, z, vertices);
    } else {
      append(((r[0] * x + r[1] * y) + r[2] * z) + t[0], ((r[3] * x + r[4] * y) + r[5] * z) + t[1],
             ((r[6] * x + r[7] * y) + r[8] * z) + t[2], vertices);
    }
  }
}

// Checks that a marker which is no deletion has points of that shape.
void checkMarker(const Marker& message, PointShape shape) {
  if (message.action != Marker::ADD) {
    reject("the marker's action is " + std::to_string(message.action) + ", not ADD (0)");
  }
  const bool is_line = shape == PointShape::kLine;
  const int type = is_line ? int{Marker::LINE_STRIP} : int{Marker::TRIANGLE_LIST};
  if (message.type != type) {
    reject("the marker's type is " + std::to_string(message.type) + ", not " +
           (is_line ? "LINE_STRIP" : "TRIANGLE_LIST") + " (" + std::to_string(type) + ")");
  }
  const std::size_t count = message.points.size();
  if (count == 0) reject("the marker has no points");
  if (!is_line && count % 3 != 0) {
    reject("the marker has " + std::to_string(count) + " points, no multiple of 3");
  }
}

// Sets the topology of a mesh whose vertices are there. It has triangles if the number of points
// differs from *point_count, which becomes that number.
void setTriangles(PointShape shape, std::size_t* point_count, DeformableMesh* mesh) {
  const std::size_t count = mesh->vertices.size() / 3;
  mesh->topology_id = static_cast<std::uint32_t>(count);
  if (count == *point_count) return;
  mesh->triangles = trianglesBetween(shape, count);
  *point_count = count;
}

// Returns the mesh of a marker that is no deletion.
IncomingMesh meshOf(const Marker& message, const ros::Time& received, PointShape shape,
                    std::size_t* point_count) {
  checkMarker(message, shape);
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  const bool stamped_on_receipt = message.header.stamp.isZero();
  if (stamped_on_receipt) mesh->header.stamp = stampOfReceipt(received);
  mesh->vertices.reserve(3 * message.points.size());
  appendPosedPoints(message, shape, &mesh->vertices);
  setTriangles(shape, point_count, mesh.get());
  return {mesh, "", stamped_on_receipt};
}

// Clouds whose points are smaller than three floats would make meshes much larger than themselves.
void checkPointStep(const PointCloud2& cloud) {
  constexpr std::uint32_t kLeastPointBytes = 3 * sizeof(float);
  if (cloud.point_step >= kLeastPointBytes) return;
  reject("point_step is " + std::to_string(cloud.point_step) + ", too few bytes for x, y and z");
}

// The overloads append the points of one message type each.
void appendPoints(const PointCloud2& cloud, std::vector<float>* vertices) {
  checkPointStep(cloud);
  CloudPoints(cloud).appendTo(vertices);
}

void appendPoints(const PoseArray& array, std::vector<float>* vertices) {
  vertices->reserve(3 * array.poses.size());
  for (const geometry_msgs::Pose& pose : array.poses) {
    append(pose.position.x, pose.position.y, pose.position.z, vertices);
  }
}

#ifdef DCM_HAS_NAV_MSGS
void appendPoints(const nav_msgs::Path& path, std::vector<float>* vertices) {
  vertices->reserve(3 * path.poses.size());
  for (std::size_t i = 0; i < path.poses.size(); ++i) {
    const std::string& frame = path.poses[i].header.frame_id;
    if (!frame.empty() && frame != path.header.frame_id) {
      reject("pose " + std::to_string(i) + " is in frame '" + frame + "', but the path is in '" +
             path.header.frame_id + "'");
    }
    const geometry_msgs::Point& at = path.poses[i].pose.position;
    append(at.x, at.y, at.z, vertices);
  }
}
#endif

#ifdef DCM_HAS_PCL_MSGS
// Checks all polygons before memory is taken for their triangles, and returns the number of those.
std::size_t triangleCount(const std::vector<pcl_msgs::Vertices>& polygons) {
  if (polygons.empty()) reject("the mesh has no polygon");
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    const std::size_t corners = polygons[i].vertices.size();
    if (corners < 3) {
      reject("polygon " + std::to_string(i) + " has " + std::to_string(corners) +
             " vertices, must have at least 3");
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
#endif

}  // namespace

std::vector<std::uint32_t> trianglesBetween(PointShape shape, std::size_t count) {
  const auto corners = static_cast<std::uint32_t>(count);
  std::vector<std::uint32_t> triangles;
  triangles.reserve(shape == PointShape::kTriangles ? count : 3 * count);
  if (shape == PointShape::kTriangles) {
    for (std::uint32_t i = 0; i < corners; ++i) triangles.push_back(i);
  } else if (shape == PointShape::kLine && count > 1) {
    for (std::uint32_t i = 1; i < corners; ++i) triangles.insert(triangles.end(), {i - 1, i, i});
  } else {
    for (std::uint32_t i = 0; i < corners; ++i) triangles.insert(triangles.end(), {i, i, i});
  }
  return triangles;
}

ros::Time correctedStamp(const ros::Time& stamp, double offset_s) {
  constexpr std::int64_t kEndNs = (std::int64_t{1} << 32) * 1000000000;
  const std::int64_t ns = static_cast<std::int64_t>(stamp.toNSec()) + std::llround(1e9 * offset_s);
  if (stamp.isZero() || ns <= 0 || ns >= kEndNs) return ros::Time();
  return ros::Time().fromNSec(static_cast<std::uint64_t>(ns));
}

void correctStamp(double offset_s, IncomingMesh* mesh) {
  if (offset_s == 0 || mesh->message == nullptr || mesh->stamp().isZero()) return;
  mesh->corrected = correctedStamp(mesh->stamp(), offset_s);
  if (mesh->corrected.isZero() && mesh->problem.empty()) {
    mesh->problem = "header.stamp plus stamp_offset_s is no time";
  }
}

IncomingMesh ShapeMeshAdapter::adapt(const Message& message, const ros::Time& received) {
  if (message.triangles.empty()) reject("the mesh has no triangle");
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header.stamp = stampOfReceipt(received);
  mesh->header.frame_id = frame_id_;
  mesh->vertices.reserve(3 * message.vertices.size());
  for (const geometry_msgs::Point& point : message.vertices) {
    append(point.x, point.y, point.z, &mesh->vertices);
  }
  if (!isSameTopology(message)) {
    mesh->triangles.reserve(3 * message.triangles.size());
    for (const shape_msgs::MeshTriangle& triangle : message.triangles) {
      mesh->triangles.insert(mesh->triangles.end(), triangle.vertex_indices.begin(),
                             triangle.vertex_indices.end());
    }
    triangles_ = mesh->triangles;
    vertex_count_ = message.vertices.size();
    ++topology_id_;
  }
  mesh->topology_id = topology_id_;
  return {mesh, "", true};
}

// Compares with the last triangles, which is much cheaper than sending and validating them again.
bool ShapeMeshAdapter::isSameTopology(const Message& message) const {
  if (message.vertices.size() != vertex_count_) return false;
  if (3 * message.triangles.size() != triangles_.size()) return false;
  auto last = triangles_.begin();
  return std::all_of(message.triangles.begin(), message.triangles.end(),
                     [&last](const shape_msgs::MeshTriangle& triangle) {
                       const auto& corners = triangle.vertex_indices;
                       const bool same = std::equal(corners.begin(), corners.end(), last);
                       last += 3;
                       return same;
                     });
}

const Marker* markerOf(const MarkerArray& message, const MarkerName& name) {
  const Marker* newest = nullptr;
  for (const Marker& marker : message.markers) {
    if (marker.action == Marker::DELETEALL || nameOf(marker) == name) newest = &marker;
  }
  return newest;
}

IncomingMesh MarkerAdapter::adapt(const Message& message, const ros::Time& received) {
  if (message.action != Marker::DELETEALL) checkIdentity(message);
  if (isDeletion(message)) {
    marker_.reset();
    return deletion(message);
  }
  IncomingMesh mesh = meshOf(message, received, shape_, &point_count_);
  marker_ = nameOf(message);
  return mesh;
}

// Checks that this marker is the object's, if it has one.
void MarkerAdapter::checkIdentity(const Message& message) const {
  const MarkerName marker = nameOf(message);
  if (marker_ && *marker_ != marker) {
    reject("it is marker " + shown(marker) + ", but the object is marker " + shown(*marker_) +
           " until that is deleted; markers need a topic each, or a marker_array");
  }
}

// Publishers send markers that did not change in no array, so one without the marker says nothing
// once the marker was seen. Before, it is probably the name that is wrong.
IncomingMesh MarkerArrayAdapter::adapt(const Message& message, const ros::Time& received) {
  const Marker* const marker = markerOf(message, name_);
  if (marker == nullptr) {
    if (is_seen_) return {};
    reject("the array has no marker " + shown(name_) + ", but " + shownNames(message));
  }
  is_seen_ = is_seen_ || nameOf(*marker) == name_;
  if (isDeletion(*marker)) return deletion(*marker);
  return meshOf(*marker, received, PointShape::kTriangles, &point_count_);
}

IncomingMesh PointCloudAdapter::adapt(const Message& message, const ros::Time& /*received*/) {
  const std::uint64_t points = std::uint64_t{message.width} * message.height;
  if (points != faces_->point_count) {
    reject("the cloud has " + sizeText(message) + " points, but its faces are of " +
           std::to_string(faces_->point_count) + " vertices");
  }
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  mesh->topology_id = 1;
  CloudPoints(message).appendTo(&mesh->vertices);
  if (!has_sent_triangles_) mesh->triangles = faces_->triangles;
  has_sent_triangles_ = true;
  return {mesh};
}

void ChangingTopology::addTo(std::vector<std::uint32_t> triangles, DeformableMesh* mesh) {
  if (triangles != triangles_ || mesh->vertices.size() != coordinate_count_) {
    triangles_ = triangles;
    coordinate_count_ = mesh->vertices.size();
    mesh->triangles = std::move(triangles);
    ++topology_id_;
  }
  mesh->topology_id = topology_id_;
}

IncomingMesh DepthCloudAdapter::adapt(const Message& message, const ros::Time& /*received*/) {
  if (message.width < 2 || message.height < 2) {
    reject("the cloud has " + sizeText(message) +
           " points, so it is not organised in rows; give its triangles by 'faces'");
  }
  checkPointStep(message);
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  CloudPoints(message).appendTo(&mesh->vertices);
  DepthSurface surface =
      depthSurface(mesh->vertices, message.width, message.height, rule_.max_depth_jump);
  const double pixels = static_cast<double>(mesh->vertices.size()) / 3;
  if (static_cast<double>(surface.pixels_with_depth) < rule_.min_seen * pixels) {
    reject("only " + std::to_string(surface.pixels_with_depth) + " of " + sizeText(message) +
           " pixels have a depth, fewer than min_seen allows");
  }
  if (surface.triangles.empty()) reject("no pixel has a depth");
  topology_.addTo(std::move(surface.triangles), mesh.get());
  return {mesh};
}

#ifdef DCM_HAS_PCL_MSGS
IncomingMesh PolygonMeshAdapter::adapt(const Message& message, const ros::Time& /*received*/) {
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  CloudPoints(message.cloud).appendTo(&mesh->vertices);
  topology_.addTo(fansOf(message.polygons), mesh.get());
  return {mesh};
}
#endif

template <typename M>
IncomingMesh PointsAdapter<M>::adapt(const Message& message, const ros::Time& /*received*/) {
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  appendPoints(message, &mesh->vertices);
  if (mesh->vertices.empty()) reject("the message has no points");
  setTriangles(shape_, &point_count_, mesh.get());
  return {mesh};
}

template class PointsAdapter<PointCloud2>;
template class PointsAdapter<PoseArray>;
#ifdef DCM_HAS_NAV_MSGS
template class PointsAdapter<nav_msgs::Path>;
#endif

}  // namespace deformable_contact_monitor
