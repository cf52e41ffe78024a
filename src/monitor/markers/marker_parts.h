// Provides what all markers of a cycle are made of: options, keys, colors and points.
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
#include "monitor/state/pair_state.h"

namespace deformable_contact_monitor {

// The settings of all markers. The first two and the rules are parameters of the node.
struct MarkerOptions {
  double lifetime_s = 0.5;            // > 0: markers vanish when the monitor stops
  std::size_t max_triangles = 20000;  // per array, > 0; the same limit holds for each kind of line
  float alpha = 0.9F;                 // opacity of contact triangles, (0, 1]
  float surface_alpha = 0.6F;         // opacity of the objects' surfaces, (0, 1]
  StateRules rules;                   // by which pairs are NEAR
};

// Identifies a marker by its namespace and id, as rviz does.
using MarkerKey = std::pair<std::string, std::int32_t>;

// Namespaces of a pair of bodies begin with one of these. That of touching triangles has no prefix.
constexpr char kSegments[] = "segments: ";
constexpr char kNormals[] = "normals: ";
constexpr char kPassed[] = "passed: ";
constexpr char kPatch[] = "patch: ";
constexpr char kWitness[] = "witness: ";
constexpr char kNearest[] = "nearest: ";
constexpr char kDistance[] = "distance: ";

// Markers of an object that is UNKNOWN live for so long [s] at least. Whoever draws them while the
// object has no cycle must do so more often.
constexpr double kUnknownLifetimeS = 1;

// Returns the key of a pair of bodies, with the namespace "<kind><a>/<b>". It stays the same while
// the bodies do.
MarkerKey pairKey(const CycleReport& report, BodyId a, BodyId b, const std::string& kind = "");

// Returns the key of an object's surface, with the object's name as namespace.
MarkerKey surfaceKey(const CycleReport& report, BodyId object);

// Returns the key of an object's held triangles, with the namespace "held: <object>".
MarkerKey heldKey(const CycleReport& report, BodyId object);

// Returns the key of the text that says why an object is UNKNOWN.
MarkerKey unknownKey(BodyId object);

// Returns a marker without points. rviz rejects an array with a marker that has none, so whoever
// publishes it must add three points per triangle, or two per line.
visualization_msgs::Marker makeMarker(const CycleReport& report, double lifetime_s, MarkerKey key,
                                      std::int32_t type);

// Returns a marker that deletes the one with that key (DELETE), or all (DELETEALL).
visualization_msgs::Marker makeRemoval(const CycleReport& report, const MarkerKey& key,
                                       std::int32_t action);

// Returns a color; all parts are in [0, 1].
std_msgs::ColorRGBA makeColor(float r, float g, float b, float alpha);

// Returns a color for each number. Numbers that follow one another have hues that are far apart.
std_msgs::ColorRGBA numberColor(std::uint32_t number, float alpha);

// Returns the color of triangles in contact: red for links, yellow for objects.
std_msgs::ColorRGBA contactColor(BodyKind kind, float alpha);

// Converts a Vec3f or a Vec3d.
template <class Vector>
geometry_msgs::Point toPoint(const Vector& v) {
  geometry_msgs::Point point;
  point.x = v.x;
  point.y = v.y;
  point.z = v.z;
  return point;
}

}  // namespace deformable_contact_monitor
