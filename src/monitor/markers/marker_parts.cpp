// What all markers of a cycle are made of: names, ids, colors, frames, points that rviz takes.
#include "monitor/markers/marker_parts.h"

#include <ros/duration.h>

namespace deformable_contact_monitor {

MarkerKey pairKey(const CycleReport& report, BodyId a, BodyId b, const std::string& kind) {
  return {kind + report.bodies[a].name + "/" + report.bodies[b].name,
          static_cast<std::int32_t>(std::size_t{a} * report.bodies.size() + b)};
}

MarkerKey surfaceKey(const CycleReport& report, BodyId object) {
  const std::size_t bodies = report.bodies.size();
  return {report.bodies[object].name, static_cast<std::int32_t>(bodies * bodies + object)};
}

visualization_msgs::Marker makeMarker(const CycleReport& report, const MarkerOptions& options,
                                      MarkerKey key, std::int32_t type) {
  visualization_msgs::Marker marker;
  marker.header = report.header;
  marker.ns = std::move(key.first);
  marker.id = key.second;
  marker.type = type;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1;
  marker.scale.x = marker.scale.y = marker.scale.z = 1;
  marker.lifetime = ros::Duration(options.lifetime_s);
  return marker;
}

std_msgs::ColorRGBA makeColor(float r, float g, float b, float alpha) {
  std_msgs::ColorRGBA c;
  c.r = r;
  c.g = g;
  c.b = b;
  c.a = alpha;
  return c;
}

std_msgs::ColorRGBA contactColor(BodyKind kind, float alpha) {
  return kind == BodyKind::kLink ? makeColor(1, 0.1F, 0.1F, alpha) : makeColor(1, 0.8F, 0, alpha);
}

geometry_msgs::Point toPoint(const Vec3f& v) {
  geometry_msgs::Point point;
  point.x = v.x;
  point.y = v.y;
  point.z = v.z;
  return point;
}

bool touches(const DetectionResult& result, std::size_t contact) {
  return result.separations_m.empty() || result.separations_m[contact] <= 0;
}

}  // namespace deformable_contact_monitor
