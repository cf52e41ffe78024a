// Meshes and markers as meshes of ours.
#include "monitor/input/mesh_adapters.h"

#include <geometry_msgs/Transform.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "monitor/input/transform_lookup.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

ros::Time stampOfReceipt(const ros::Time& received) {
  if (received.isZero()) refuse("it has no stamp, and /clock is silent: no time of its receipt");
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

bool isFinite(double x, double y, double z) {
  return std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
}

geometry_msgs::Quaternion orientationOf(const Marker& marker) {
  constexpr double kTolerance = 1e-2;  // as tf2 and rviz have it
  geometry_msgs::Quaternion q = marker.pose.orientation;
  if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0) q.w = 1;
  const double squared = ((q.x * q.x + q.y * q.y) + q.z * q.z) + q.w * q.w;
  if (!(std::abs(squared - 1) <= kTolerance)) {
    refuse("pose.orientation is no unit quaternion: its length is " +
           std::to_string(std::sqrt(squared)));
  }
  return q;
}

geometry_msgs::Transform poseOf(const Marker& marker) {
  const geometry_msgs::Point& at = marker.pose.position;
  const geometry_msgs::Vector3& scale = marker.scale;
  if (!isFinite(at.x, at.y, at.z)) refuse("pose.position is not finite");
  if (!isFinite(scale.x, scale.y, scale.z)) refuse("scale is not finite");
  if (scale.x == 0 || scale.y == 0 || scale.z == 0) refuse("scale is zero in x, y or z");
  geometry_msgs::Transform pose;
  pose.translation.x = at.x;
  pose.translation.y = at.y;
  pose.translation.z = at.z;
  pose.rotation = orientationOf(marker);
  return pose;
}

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

}  // namespace

ReceivedMesh ShapeMeshAdapter::adapt(const Message& message, const ros::Time& received) {
  if (message.triangles.empty()) refuse("the mesh has no triangle");
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

ReceivedMesh MarkerAdapter::adapt(const Message& message, const ros::Time& received) {
  checkIdentity(message);
  if (message.type != Marker::TRIANGLE_LIST) {
    refuse("the marker's type is " + std::to_string(message.type) + ", not TRIANGLE_LIST (" +
           std::to_string(Marker::TRIANGLE_LIST) + ")");
  }
  const std::size_t count = message.points.size();
  if (count == 0) refuse("the marker has no points");
  if (count % 3 != 0) {
    refuse("the marker has " + std::to_string(count) + " points, no multiple of 3");
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

// That this marker is the object's, and is not being deleted.
void MarkerAdapter::checkIdentity(const Message& message) {
  if (message.action == Marker::DELETEALL) {
    marker_.reset();
    refuse("all markers were deleted (DELETEALL)");
  }
  const std::pair<std::string, std::int32_t> marker{message.ns, message.id};
  if (marker_ && *marker_ != marker) {
    refuse("it is marker " + shown(message.ns, message.id) + ", but the object is marker " +
           shown(marker_->first, marker_->second) +
           " until that is deleted; markers need a topic each");
  }
  if (message.action == Marker::DELETE) {
    marker_.reset();
    refuse("marker " + shown(message.ns, message.id) + " was deleted");
  }
  if (message.action != Marker::ADD) {
    refuse("the marker's action is " + std::to_string(message.action) + ", not ADD (0)");
  }
}

}  // namespace deformable_contact_monitor
