// What all markers of a cycle are made of: names, ids, colors, frames, points that rviz takes.
#pragma once

#include <geometry_msgs/Point.h>
#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/Marker.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "core/vector3.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

struct MarkerOptions {
  double lifetime_s = 0.5;            // > 0: markers vanish when the monitor does
  std::size_t max_triangles = 20000;  // in one array, > 0; and as many lines of each kind
  float alpha = 0.9F;                 // of contact triangles, (0, 1]
  float surface_alpha = 0.6F;         // of the objects' surfaces, (0, 1]
};

// What identifies a marker; stable while the bodies are the same.
using MarkerKey = std::pair<std::string, std::int32_t>;  // namespace and id

// "<kind><a>/<b>".
MarkerKey pairKey(const CycleReport& report, BodyId a, BodyId b, const std::string& kind = "");
// "<object>".
MarkerKey surfaceKey(const CycleReport& report, BodyId object);

// Begins the namespace of what touched since the cycle before, and does not any more.
constexpr char kPassed[] = "passed: ";

// Without points yet: rviz takes it with three a triangle, or two a line, and none of them empty.
visualization_msgs::Marker makeMarker(const CycleReport& report, const MarkerOptions& options,
                                      MarkerKey key, std::int32_t type);

std_msgs::ColorRGBA makeColor(float r, float g, float b, float alpha);
// Of what touches: links red, objects yellow.
std_msgs::ColorRGBA contactColor(BodyKind kind, float alpha);
geometry_msgs::Point toPoint(const Vec3f& v);

// Whether a contact touches, rather than being near.
bool touches(const DetectionResult& result, std::size_t contact);

}  // namespace deformable_contact_monitor
