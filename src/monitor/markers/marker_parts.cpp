// Provides what all markers of a cycle are made of: options, keys, colors and points.
#include "monitor/markers/marker_parts.h"

#include <ros/duration.h>

#include <algorithm>
#include <cmath>

namespace deformable_contact_monitor {

using visualization_msgs::Marker;

// An id is unique within its namespace anyway. It is unique among all pairs and surfaces as well,
// because two bodies may have names that give the same namespace.
MarkerKey pairKey(const CycleReport& report, BodyId a, BodyId b, const std::string& kind) {
  return {kind + report.bodies.at(a).name + "/" + report.bodies.at(b).name,
          static_cast<std::int32_t>(std::size_t{a} * report.bodies.size() + b)};
}

MarkerKey surfaceKey(const CycleReport& report, BodyId object) {
  const std::size_t bodies = report.bodies.size();
  return {report.bodies[object].name, static_cast<std::int32_t>(bodies * bodies + object)};
}

MarkerKey heldKey(const CycleReport& report, BodyId object) {
  return {"held: " + report.bodies[object].name, static_cast<std::int32_t>(object)};
}

MarkerKey unknownKey(BodyId object) { return {"unknown", static_cast<std::int32_t>(object)}; }

// rviz complains about an orientation of zeros, hence w = 1 here and below.
Marker makeMarker(const CycleReport& report, double lifetime_s, MarkerKey key, std::int32_t type) {
  Marker marker;
  marker.header = report.header;
  marker.ns = std::move(key.first);
  marker.id = key.second;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1;
  marker.scale.x = marker.scale.y = marker.scale.z = 1;
  marker.lifetime = ros::Duration(lifetime_s);
  return marker;
}

Marker makeRemoval(const CycleReport& report, const MarkerKey& key, std::int32_t action) {
  Marker marker;
  marker.header = report.header;
  marker.ns = key.first;
  marker.id = key.second;
  marker.action = action;
  marker.pose.orientation.w = 1;
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

// Each step turns the color wheel by the golden ratio.
std_msgs::ColorRGBA numberColor(std::uint32_t number, float alpha) {
  constexpr double kGoldenRatio = 0.61803398875;
  const double hue = 6 * std::fmod(number * kGoldenRatio, 1.0);
  const auto channel = [hue](double peak) {
    const double off = std::fabs(hue - peak);
    return static_cast<float>(std::clamp(2 - std::min(off, 6 - off), 0.0, 1.0));
  };
  return makeColor(channel(0), channel(2), channel(4), alpha);
}

std_msgs::ColorRGBA contactColor(BodyKind kind, float alpha) {
  return kind != BodyKind::kDeformable ? makeColor(1, 0.1F, 0.1F, alpha)
                                       : makeColor(1, 0.8F, 0, alpha);
}

}  // namespace deformable_contact_monitor
