// Patches of contacts as rviz markers.
#include "monitor/markers/patch_markers.h"

#include <geometry_msgs/Point.h>
#include <ros/duration.h>
#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/Marker.h>

#include <algorithm>
#include <cmath>

#include "core/common/posed_body.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;

constexpr double kLineWidthM = 0.001, kArrowM = 0.05, kTextM = 0.02;

enum Part : std::int32_t { kOutline, kArrow, kText, kParts };

std::string namespaceOf(const CycleReport& report, BodyId a, BodyId b) {
  return "patch: " + report.bodies.at(a).name + "/" + report.bodies.at(b).name;
}

// Hues that follow one another are far apart on the colour wheel.
std_msgs::ColorRGBA colorOf(std::uint32_t id) {
  constexpr double kGoldenShare = 0.61803398875;
  const double hue = 6 * std::fmod(id * kGoldenShare, 1.0);
  const auto channel = [hue](double peak) {
    const double off = std::fabs(hue - peak);
    return static_cast<float>(std::clamp(2 - std::min(off, 6 - off), 0.0, 1.0));
  };
  std_msgs::ColorRGBA color;
  color.r = channel(0);
  color.g = channel(2);
  color.b = channel(4);
  color.a = 1;
  return color;
}

geometry_msgs::Point toPoint(const Vec3d& v) {
  geometry_msgs::Point point;
  point.x = v.x;
  point.y = v.y;
  point.z = v.z;
  return point;
}

class PatchDrawing {
 public:
  PatchDrawing(const CycleReport& report, const MarkerOptions& options, const Patch& patch)
      : report_(report), options_(options), patch_(patch) {}

  Marker outline(std::size_t most_triangles) const {
    Marker marker = start(kOutline, Marker::LINE_LIST);
    marker.scale.x = kLineWidthM;
    addOutlines(patch_.body_a, patch_.triangles_a, most_triangles / 2, &marker);
    addOutlines(patch_.body_b, patch_.triangles_b, most_triangles / 2, &marker);
    return marker;
  }

  bool hasNormal() const { return dot(patch_.normal, patch_.normal) > 0; }

  Marker arrow() const {
    Marker marker = start(kArrow, Marker::ARROW);
    marker.scale.x = 0.1 * kArrowM;  // of the shaft, the head, and the head's length
    marker.scale.y = 0.2 * kArrowM;
    marker.scale.z = 0.3 * kArrowM;
    marker.points = {toPoint(patch_.centroid), toPoint(patch_.centroid + patch_.normal * kArrowM)};
    return marker;
  }

  Marker text() const {
    Marker marker = start(kText, Marker::TEXT_VIEW_FACING);
    marker.scale.z = kTextM;
    marker.pose.position = toPoint(patch_.centroid);
    marker.text = std::to_string(patch_.id);
    return marker;
  }

 private:
  Marker start(Part part, std::int32_t type) const {
    constexpr std::uint32_t kMostIds = 0x7fffffffU / kParts;
    Marker marker;
    marker.header = report_.header;
    marker.ns = namespaceOf(report_, patch_.body_a, patch_.body_b);
    marker.id = static_cast<std::int32_t>(patch_.id % kMostIds) * kParts + part;
    marker.type = type;
    marker.action = Marker::ADD;
    marker.pose.orientation.w = 1;
    marker.color = colorOf(patch_.id);
    marker.lifetime = ros::Duration(options_.lifetime_s);
    return marker;
  }

  void addOutlines(BodyId id, const std::vector<std::uint32_t>& triangles, std::size_t most,
                   Marker* marker) const {
    const PosedBody body(report_.scene->body(id));
    for (std::size_t i = 0; i < std::min(triangles.size(), std::max<std::size_t>(most, 1)); ++i) {
      const Triangle corners = body.triangle(triangles[i]);
      for (int k = 0; k < 3; ++k) {
        marker->points.push_back(toPoint(toDouble(corners.v[k])));
        marker->points.push_back(toPoint(toDouble(corners.v[(k + 1) % 3])));
      }
    }
  }

  const CycleReport& report_;
  const MarkerOptions& options_;
  const Patch& patch_;
};

Marker removal(const CycleReport& report, const std::string& name, std::int32_t id) {
  Marker marker;
  marker.header = report.header;
  marker.ns = name;
  marker.id = id;
  marker.action = Marker::DELETE;
  marker.pose.orientation.w = 1;
  return marker;
}

}  // namespace

void PatchMarkers::add(const CycleReport& report, const std::vector<Patch>* patches,
                       visualization_msgs::MarkerArray* array) {
  if (patches == nullptr && drawn_.empty()) return;
  std::vector<Marker> markers;
  for (const Patch& patch : patches == nullptr ? std::vector<Patch>() : *patches) {
    const PatchDrawing drawing(report, options_, patch);
    markers.push_back(drawing.outline(options_.max_triangles / patches->size()));
    if (drawing.hasNormal()) markers.push_back(drawing.arrow());
    markers.push_back(drawing.text());
  }
  std::set<std::string> looked_at;
  for (const MonitoredPair& pair : report.pairs) {
    if (isOfCycle(report.bodies, pair)) looked_at.insert(namespaceOf(report, pair.a, pair.b));
  }
  std::set<std::pair<std::string, std::int32_t>> now;
  for (const Marker& marker : markers) now.insert({marker.ns, marker.id});
  for (auto drawn = drawn_.begin(); drawn != drawn_.end();) {
    if (looked_at.count(drawn->first) == 0 || now.count(*drawn) > 0) {
      ++drawn;
      continue;
    }
    array->markers.push_back(removal(report, drawn->first, drawn->second));
    drawn = drawn_.erase(drawn);
  }
  drawn_.insert(now.begin(), now.end());
  array->markers.insert(array->markers.end(), markers.begin(), markers.end());
}

}  // namespace deformable_contact_monitor
