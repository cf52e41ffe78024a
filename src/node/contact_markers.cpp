// Contacts and deformable objects as rviz markers.
#include "node/contact_markers.h"

#include <geometry_msgs/Point.h>
#include <ros/duration.h>
#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/Marker.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/vector3.h"
#include "node/posed_triangle.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;

std_msgs::ColorRGBA color(float r, float g, float b, float alpha) {
  std_msgs::ColorRGBA c;
  c.r = r;
  c.g = g;
  c.b = b;
  c.a = alpha;
  return c;
}

std_msgs::ColorRGBA contactColor(BodyKind kind, float alpha) {
  return kind == BodyKind::kLink ? color(1, 0.1F, 0.1F, alpha) : color(1, 0.8F, 0, alpha);
}

// The triangles to draw of one pair of bodies, by body.
using Drawn = std::map<BodyId, std::set<std::uint32_t>>;

std::size_t size(const Drawn& drawn) {
  std::size_t triangles = 0;
  for (const auto& [body, set] : drawn) triangles += set.size();
  return triangles;
}

class MarkerBuilder {
 public:
  MarkerBuilder(const CycleReport& report, const MarkerOptions& options)
      : report_(report), options_(options), budget_(options.max_triangles) {}

  visualization_msgs::MarkerArray build() {
    Marker clear;
    clear.header = report_.header;
    clear.action = Marker::DELETEALL;
    clear.pose.orientation.w = 1;
    array_.markers.push_back(clear);
    if (report_.scene == nullptr) return std::move(array_);
    if (report_.result != nullptr) addContacts();
    for (BodyId id = 0; id < report_.bodies.size(); ++id) {
      const BodyStatus& body = report_.bodies[id];
      if (body.kind == BodyKind::kDeformable && body.unknown_because.empty()) addSurface(id);
    }
    return std::move(array_);
  }

 private:
  Marker triangleList(std::string name, std::size_t id) const {
    Marker marker;
    marker.header = report_.header;
    marker.ns = std::move(name);
    marker.id = static_cast<std::int32_t>(id);
    marker.type = Marker::TRIANGLE_LIST;
    marker.action = Marker::ADD;
    marker.pose.orientation.w = 1;
    marker.scale.x = marker.scale.y = marker.scale.z = 1;
    marker.lifetime = ros::Duration(options_.lifetime_s);
    return marker;
  }

  // False, and nothing added, for a triangle that rviz would refuse.
  bool addTriangle(BodyId body, std::uint32_t triangle, Marker* marker) const {
    const std::array<Vec3f, 3> corners = PosedBody(report_.scene->body(body)).triangle(triangle);
    if (!std::all_of(corners.begin(), corners.end(), isFinite)) return false;
    for (const Vec3f& corner : corners) {
      geometry_msgs::Point point;
      point.x = corner.x;
      point.y = corner.y;
      point.z = corner.z;
      marker->points.push_back(point);
    }
    return true;
  }

  std::map<std::pair<BodyId, BodyId>, Drawn> drawnPairs() const {
    std::map<std::pair<BodyId, BodyId>, Drawn> pairs;
    for (const TrianglePair& c : report_.result->contacts) pairs[{c.body_a, c.body_b}];
    const std::size_t share = pairs.empty() ? 0 : budget_ / pairs.size();
    for (const TrianglePair& c : report_.result->contacts) {
      Drawn& drawn = pairs[{c.body_a, c.body_b}];
      if (size(drawn) + 2 > share) continue;
      drawn[c.body_a].insert(c.triangle_a);
      drawn[c.body_b].insert(c.triangle_b);
    }
    return pairs;
  }

  void addContacts() {
    for (const auto& [pair, drawn] : drawnPairs()) {
      const auto& [a, b] = pair;
      Marker marker = triangleList(report_.bodies[a].name + "/" + report_.bodies[b].name,
                                   std::size_t{a} * report_.bodies.size() + b);
      for (const auto& [body, triangles] : drawn) {
        const auto tint = contactColor(report_.bodies[body].kind, options_.alpha);
        for (const std::uint32_t triangle : triangles) {
          if (!addTriangle(body, triangle, &marker)) continue;
          marker.colors.insert(marker.colors.end(), 3, tint);
          highlighted_[body].insert(triangle);
        }
      }
      marker.color = contactColor(BodyKind::kLink, options_.alpha);
      add(std::move(marker));
    }
  }

  // Highlighted triangles are left out: two coplanar triangles flicker.
  void addSurface(BodyId id) {
    const std::size_t triangles = report_.scene->body(id).mesh.triangleCount();
    if (budget_ == 0 || triangles == 0) return;
    const std::size_t stride = (triangles + budget_ - 1) / budget_;
    const std::set<std::uint32_t>& highlighted = highlighted_[id];
    const std::size_t bodies = report_.bodies.size();
    Marker marker = triangleList(report_.bodies[id].name, bodies * bodies + id);
    for (std::size_t t = 0; t < triangles; t += stride) {
      const auto triangle = static_cast<std::uint32_t>(t);
      if (highlighted.count(triangle) == 0) addTriangle(id, triangle, &marker);
    }
    marker.color = color(0.45F, 0.7F, 1, options_.surface_alpha);
    add(std::move(marker));
  }

  void add(Marker marker) {
    if (marker.points.empty()) return;
    budget_ -= marker.points.size() / 3;
    array_.markers.push_back(std::move(marker));
  }

  const CycleReport& report_;
  const MarkerOptions& options_;
  std::size_t budget_;  // triangles that may still be drawn
  std::map<BodyId, std::set<std::uint32_t>> highlighted_;
  visualization_msgs::MarkerArray array_;
};

}  // namespace

visualization_msgs::MarkerArray ContactMarkers::make(const CycleReport& report) const {
  return MarkerBuilder(report, options_).build();
}

}  // namespace deformable_contact_monitor
