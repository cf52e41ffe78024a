// Makes the load: links in a square array, and a deforming mesh through each of them.
#include "load_scene.h"

#include <geometry_msgs/TransformStamped.h>

#include <cmath>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kStates = 8;
constexpr std::size_t kLinksInARow = 10;

Vec3f placeOf(std::size_t n) {
  return {static_cast<float>(n % kLinksInARow), static_cast<float>(n / kLinksInARow), 0.0F};
}

}  // namespace

std::string linkName(std::size_t n) { return "link_" + std::to_string(n); }
std::string objectName(std::size_t n) { return "object_" + std::to_string(n); }

tf2_msgs::TFMessage linkTransforms(std::size_t count, const ros::Time& stamp) {
  constexpr double kAmplitudeM = 0.1;
  tf2_msgs::TFMessage message;
  for (std::size_t n = 0; n < count; ++n) {
    const Vec3f place = placeOf(n);
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = stamp;
    transform.header.frame_id = kLoadFrame;
    transform.child_frame_id = linkName(n);
    transform.transform.translation.x = place.x;
    transform.transform.translation.y = place.y;
    transform.transform.translation.z =
        kAmplitudeM * std::sin(stamp.toSec() + static_cast<double>(n));
    transform.transform.rotation.w = 1;
    message.transforms.push_back(transform);
  }
  return message;
}

LoadObject::LoadObject(std::size_t n, const TriangleMesh& mesh)
    : states_(kStates), triangles_(mesh.triangles) {
  constexpr float kAmplitudeM = 0.02F;
  constexpr float kTurn = 6.2831853F;
  const Vec3f place = placeOf(n);
  for (std::size_t i = 0; i < kStates; ++i) {
    DeformableMesh& state = states_[i];
    state.header.frame_id = kLoadFrame;
    state.object = objectName(n);
    state.topology_id = 1;
    const float phase = kTurn * static_cast<float>(i) / kStates;
    for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
      const Vec3f at = mesh.vertex(v);
      const float z = at.z + kAmplitudeM * std::sin(phase + at.x);
      state.vertices.insert(state.vertices.end(), {at.x + place.x, at.y + place.y, z});
    }
  }
}

const DeformableMesh& LoadObject::next(const ros::Time& stamp, std::size_t keyframe_period) {
  DeformableMesh& state = states_[sent_ % kStates];
  state.header.stamp = stamp;
  state.triangles.clear();
  if (sent_ < keyframe_period || sent_ % keyframe_period == 0) state.triangles = triangles_;
  ++sent_;
  return state;
}

}  // namespace deformable_contact_monitor
