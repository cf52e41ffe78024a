// Adapters that convert messages of other types to DeformableMesh. Every check throws by reject(),
// so a message is either converted as a whole or has no effect.
#include "monitor/input/mesh_adapters.h"

#include <geometry_msgs/Transform.h>
#include <sensor_msgs/PointField.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <numeric>
#include <stdexcept>

#include "monitor/input/transform_lookup.h"

namespace deformable_contact_monitor {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;
using visualization_msgs::Marker;

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

std::string shown(const std::string& marker_namespace, std::int32_t id) {
  return "'" + marker_namespace + "'/" + std::to_string(id);
}

// Returns the invalid mesh that stands for a deletion.
IncomingMesh deletion(const Marker& message, const std::string& why) {
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  IncomingMesh deleted{mesh, why};
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

geometry_msgs::Transform poseOf(const Marker& marker) {
  const geometry_msgs::Point& at = marker.pose.position;
  const geometry_msgs::Vector3& scale = marker.scale;
  if (!isFinite(at.x, at.y, at.z)) reject("pose.position is not finite");
  if (!isFinite(scale.x, scale.y, scale.z)) reject("scale is not finite");
  if (scale.x == 0 || scale.y == 0 || scale.z == 0) reject("scale is zero in x, y or z");
  geometry_msgs::Transform pose;
  pose.translation.x = at.x;
  pose.translation.y = at.y;
  pose.translation.z = at.z;
  pose.rotation = orientationOf(marker);
  return pose;
}

// Writes the sums out in their order, so that results do not depend on the compiler.
void appendPosedPoints(const Marker& marker, std::vector<float>* vertices) {
  const RigidTransform pose = toRigidTransform(poseOf(marker));
  const geometry_msgs::Vector3& scale = marker.scale;
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

// The place of one coordinate within a point of a cloud.
struct Place {
  std::size_t offset;  // [bytes] from the point's first byte
  bool is_double;
};

// Finds a coordinate's field by its name.
Place placeOf(const std::string& name, const PointCloud2& cloud) {
  const PointField* found = nullptr;
  for (const PointField& field : cloud.fields) {
    if (field.name != name) continue;
    if (found != nullptr) reject("the cloud has two fields '" + name + "'");
    found = &field;
  }
  if (found == nullptr) reject("the cloud has no field '" + name + "'");
  const bool is_double = found->datatype == PointField::FLOAT64;
  if (!is_double && found->datatype != PointField::FLOAT32) {
    reject("field '" + name + "' has datatype " + std::to_string(found->datatype) +
           ", neither FLOAT32 (7) nor FLOAT64 (8)");
  }
  if (found->count > 1) {  // some publishers leave it 0
    reject("field '" + name + "' has count " + std::to_string(found->count) + ", not 1");
  }
  const std::uint64_t end =
      std::uint64_t{found->offset} + (is_double ? sizeof(double) : sizeof(float));
  if (end > cloud.point_step) {
    reject("field '" + name + "' ends at byte " + std::to_string(end) + ", but point_step is " +
           std::to_string(cloud.point_step));
  }
  return {found->offset, is_double};
}

// Checks that there are as many points as vertices, and that all of them lie within the data. Sizes
// are multiplied in 64 bits, where products of two 32-bit fields cannot wrap.
void checkLayout(const PointCloud2& cloud, std::size_t vertex_count) {
  if (cloud.is_bigendian != 0) reject("the cloud is big-endian");
  const std::uint64_t points = std::uint64_t{cloud.width} * cloud.height;
  if (points != vertex_count) {
    reject("the cloud has " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
           " points, but its faces are of " + std::to_string(vertex_count) + " vertices");
  }
  const std::uint64_t row_bytes = std::uint64_t{cloud.point_step} * cloud.width;
  if (row_bytes > cloud.row_step) {
    reject("row_step is " + std::to_string(cloud.row_step) + ", but a row has " +
           std::to_string(row_bytes) + " bytes");
  }
  const std::uint64_t bytes = std::uint64_t{cloud.row_step} * cloud.height;
  if (bytes != cloud.data.size()) {
    reject("data has " + std::to_string(cloud.data.size()) + " bytes, but row_step x height is " +
           std::to_string(bytes));
  }
}

// Reads a coordinate; it may lie at any address, so the bytes are copied.
float coordinateAt(const std::uint8_t* point, const Place& place) {
  if (place.is_double) {
    double value = 0;
    std::memcpy(&value, point + place.offset, sizeof value);
    return static_cast<float>(value);
  }
  float value = 0;
  std::memcpy(&value, point + place.offset, sizeof value);
  return value;
}

}  // namespace

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

IncomingMesh MarkerAdapter::adapt(const Message& message, const ros::Time& received) {
  if (message.action == Marker::DELETEALL) {
    marker_.reset();
    return deletion(message, "all markers were deleted (DELETEALL)");
  }
  checkIdentity(message);
  if (message.action == Marker::DELETE) {
    marker_.reset();
    return deletion(message, "marker " + shown(message.ns, message.id) + " was deleted");
  }
  if (message.action != Marker::ADD) {
    reject("the marker's action is " + std::to_string(message.action) + ", not ADD (0)");
  }
  if (message.type != Marker::TRIANGLE_LIST) {
    reject("the marker's type is " + std::to_string(message.type) + ", not TRIANGLE_LIST (" +
           std::to_string(Marker::TRIANGLE_LIST) + ")");
  }
  const std::size_t count = message.points.size();
  if (count == 0) reject("the marker has no points");
  if (count % 3 != 0) {
    reject("the marker has " + std::to_string(count) + " points, no multiple of 3");
  }
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  const bool stamped_on_receipt = message.header.stamp.isZero();
  if (stamped_on_receipt) mesh->header.stamp = stampOfReceipt(received);
  mesh->topology_id = static_cast<std::uint32_t>(count / 3);
  mesh->vertices.reserve(3 * count);
  appendPosedPoints(message, &mesh->vertices);
  if (count != point_count_) {
    mesh->triangles.resize(count);
    std::iota(mesh->triangles.begin(), mesh->triangles.end(), 0U);
    point_count_ = count;
  }
  marker_.emplace(message.ns, message.id);
  return {mesh, "", stamped_on_receipt};
}

// Checks that this marker is the object's, if it has one.
void MarkerAdapter::checkIdentity(const Message& message) const {
  const std::pair<std::string, std::int32_t> marker{message.ns, message.id};
  if (marker_ && *marker_ != marker) {
    reject("it is marker " + shown(message.ns, message.id) + ", but the object is marker " +
           shown(marker_->first, marker_->second) +
           " until that is deleted; markers need a topic each");
  }
}

IncomingMesh PointCloudAdapter::adapt(const Message& message, const ros::Time& /*received*/) {
  checkLayout(message, faces_->vertexCount());
  const Place places[] = {placeOf("x", message), placeOf("y", message), placeOf("z", message)};
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  mesh->topology_id = 1;
  mesh->vertices.reserve(3 * faces_->vertexCount());
  for (std::size_t row = 0; row < message.height; ++row) {
    const std::uint8_t* point = message.data.data() + row * message.row_step;
    for (std::size_t i = 0; i < message.width; ++i, point += message.point_step) {
      for (const Place& place : places) mesh->vertices.push_back(coordinateAt(point, place));
    }
  }
  if (!has_sent_triangles_) mesh->triangles = faces_->triangles;
  has_sent_triangles_ = true;
  return {mesh};
}

}  // namespace deformable_contact_monitor
