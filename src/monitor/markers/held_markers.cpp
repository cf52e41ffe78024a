// Objects that are held, as text in rviz.
#include "monitor/markers/held_markers.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/common/posed_body.h"
#include "core/predicates/aabb.h"
#include "monitor/rules/attach_object.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;

constexpr double kTextShare = 0.1;  // of the object's longest side
constexpr double kLeastTextM = 0.01, kMostTextM = 0.2;

// Of its finite vertices.
Aabb boxOf(const Body& body) {
  const PosedBody posed(body);
  Aabb box;
  for (std::size_t i = 0; i < body.mesh.vertexCount(); ++i) {
    const Vec3f v = posed.vertex(i);
    if (std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z)) box.include(v);
  }
  return box;
}

Marker textOver(const Aabb& box, const std::string& text) {
  Marker marker;
  marker.ns = "held";
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.action = Marker::ADD;
  const double longest = std::max({double{box.max.x} - box.min.x, double{box.max.y} - box.min.y,
                                   double{box.max.z} - box.min.z});
  marker.scale.z = std::clamp(kTextShare * longest, kLeastTextM, kMostTextM);
  marker.pose.position.x = (double{box.min.x} + box.max.x) / 2;
  marker.pose.position.y = (double{box.min.y} + box.max.y) / 2;
  marker.pose.position.z = box.max.z + marker.scale.z;
  marker.pose.orientation.w = 1;
  marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1;
  marker.text = text;
  return marker;
}

}  // namespace

void addHeldMarkers(const CycleReport& report, double lifetime_s,
                    visualization_msgs::MarkerArray* markers) {
  if (report.scene == nullptr) return;
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const BodyStatus& body = report.bodies[id];
    const auto held = report.attached.find(body.name);
    if (held == report.attached.end() || body.kind != BodyKind::kDeformable) continue;
    if (!body.triggered || !body.unknown_because.empty()) continue;
    const Aabb box = boxOf(report.scene->body(id));
    if (box.empty()) continue;
    Marker marker = textOver(box, "held: " + describeHeld(held->first, held->second));
    marker.header = report.header;
    marker.id = static_cast<std::int32_t>(id);
    marker.lifetime = ros::Duration(lifetime_s);
    markers->markers.push_back(std::move(marker));
  }
}

}  // namespace deformable_contact_monitor
