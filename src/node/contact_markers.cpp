// Contacts and deformable objects as rviz markers.
#include "node/contact_markers.h"

#include <geometry_msgs/Point.h>
#include <ros/duration.h>
#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/Marker.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/posed_body.h"
#include "core/predicates/triangle.h"

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

std_msgs::ColorRGBA nearColor(BodyKind kind, float alpha) {
  return kind == BodyKind::kLink ? color(1, 0.7F, 0.7F, alpha) : color(1, 0.95F, 0.7F, alpha);
}

// Triangles of one body, each once. Contacts are many, and the next cycle waits for the markers.
class TriangleSet {
 public:
  explicit TriangleSet(const Body& body) : has_(body.mesh.triangleCount()) {}
  bool has(std::uint32_t triangle) const { return has_[triangle]; }
  void insert(std::uint32_t triangle) {
    if (has_[triangle]) return;
    has_[triangle] = true;
    list_.push_back(triangle);
  }
  const std::vector<std::uint32_t>& list() const { return list_; }

 private:
  std::vector<bool> has_;
  std::vector<std::uint32_t> list_;
};

// The triangles to draw of one pair of bodies; of a body with itself, all in `a`.
struct Drawn {
  TriangleSet a, b;
  std::size_t touching_a = 0, touching_b = 0;  // the first of them touch, the others are near
  std::size_t size() const { return a.list().size() + b.list().size(); }
};

using BodyPair = std::pair<BodyId, BodyId>;

std::string contactName(const CycleReport& report, BodyId a, BodyId b) {
  return report.bodies[a].name + "/" + report.bodies[b].name;
}

std::int32_t contactId(const CycleReport& report, BodyId a, BodyId b) {
  return static_cast<std::int32_t>(std::size_t{a} * report.bodies.size() + b);
}

std::int32_t surfaceId(const CycleReport& report, BodyId id) {
  return static_cast<std::int32_t>(report.bodies.size() * report.bodies.size() + id);
}

class MarkerBuilder {
 public:
  MarkerBuilder(const CycleReport& report, const MarkerOptions& options)
      : report_(report), options_(options), budget_(options.max_triangles) {}

  std::vector<Marker> build() {
    if (report_.scene == nullptr) return {};
    if (report_.result != nullptr) addContacts();
    for (BodyId id = 0; id < report_.bodies.size(); ++id) {
      const BodyStatus& body = report_.bodies[id];
      const bool is_object = body.kind == BodyKind::kDeformable;
      if (is_object && body.triggered && body.unknown_because.empty()) addSurface(id);
    }
    return std::move(markers_);
  }

 private:
  Marker triangleList(std::string name, std::int32_t id) const {
    Marker marker;
    marker.header = report_.header;
    marker.ns = std::move(name);
    marker.id = id;
    marker.type = Marker::TRIANGLE_LIST;
    marker.action = Marker::ADD;
    marker.pose.orientation.w = 1;
    marker.scale.x = marker.scale.y = marker.scale.z = 1;
    marker.lifetime = ros::Duration(options_.lifetime_s);
    return marker;
  }

  // False, and nothing added, for a triangle that rviz would refuse.
  bool addTriangle(BodyId id, std::uint32_t triangle, Marker* marker) const {
    const Triangle corners = PosedBody(body(id)).triangle(triangle);
    if (!isFinite(corners)) return false;
    for (const Vec3f& corner : corners.v) {
      geometry_msgs::Point point;
      point.x = corner.x;
      point.y = corner.y;
      point.z = corner.z;
      marker->points.push_back(point);
    }
    return true;
  }

  const Body& body(BodyId id) const { return report_.scene->body(id); }

  bool touches(std::size_t contact) const {
    const std::vector<float>& separations_m = report_.result->separations_m;
    return separations_m.empty() || separations_m[contact] <= 0;
  }

  // Calls visit(contact, what is drawn of its pair of bodies) for those that touch, or for those
  // that are near. Those of a pair mostly follow one another.
  template <class Visit>
  void forEachContact(bool touching, std::map<BodyPair, Drawn>* pairs, const Visit& visit) const {
    auto of_last = pairs->end();
    for (std::size_t i = 0; i < report_.result->contacts.size(); ++i) {
      if (touches(i) != touching) continue;
      const TrianglePair& c = report_.result->contacts[i];
      const BodyPair pair{c.body_a, c.body_b};
      if (of_last == pairs->end() || of_last->first != pair) {
        of_last = pairs->find(pair);
        if (of_last == pairs->end()) {
          const Drawn nothing{TriangleSet(body(c.body_a)), TriangleSet(body(c.body_b)), 0, 0};
          of_last = pairs->emplace(pair, nothing).first;
        }
      }
      visit(c, &of_last->second);
    }
  }

  std::map<BodyPair, Drawn> drawnPairs() const {
    const bool any_near = !report_.result->separations_m.empty();
    std::map<BodyPair, Drawn> pairs;
    forEachContact(true, &pairs, [](const TrianglePair&, Drawn*) {});
    if (any_near) forEachContact(false, &pairs, [](const TrianglePair&, Drawn*) {});
    const std::size_t share = pairs.empty() ? 0 : budget_ / pairs.size();
    const auto draw = [share](const TrianglePair& c, Drawn* drawn) {
      if (drawn->size() + 2 > share) return;
      drawn->a.insert(c.triangle_a);
      (c.body_a == c.body_b ? drawn->a : drawn->b).insert(c.triangle_b);
    };
    forEachContact(true, &pairs, draw);
    for (auto& [pair, drawn] : pairs) {
      drawn.touching_a = drawn.a.list().size();
      drawn.touching_b = drawn.b.list().size();
    }
    if (any_near) forEachContact(false, &pairs, draw);
    return pairs;
  }

  void addContacts() {
    for (const auto& [pair, drawn] : drawnPairs()) {
      const auto& [a, b] = pair;
      Marker marker = triangleList(contactName(report_, a, b), contactId(report_, a, b));
      marker.points.reserve(3 * drawn.size());
      marker.colors.reserve(3 * drawn.size());
      highlight(a, drawn.a, drawn.touching_a, &marker);
      highlight(b, drawn.b, drawn.touching_b, &marker);
      marker.color = contactColor(BodyKind::kLink, options_.alpha);
      add(std::move(marker));
    }
  }

  void highlight(BodyId id, const TriangleSet& triangles, std::size_t touching, Marker* marker) {
    TriangleSet& highlighted = highlighted_.try_emplace(id, body(id)).first->second;
    const BodyKind kind = report_.bodies[id].kind;
    for (std::size_t i = 0; i < triangles.list().size(); ++i) {
      const std::uint32_t triangle = triangles.list()[i];
      if (!addTriangle(id, triangle, marker)) continue;
      marker->colors.insert(
          marker->colors.end(), 3,
          i < touching ? contactColor(kind, options_.alpha) : nearColor(kind, options_.alpha));
      highlighted.insert(triangle);
    }
  }

  // Highlighted triangles are left out: two coplanar triangles flicker.
  void addSurface(BodyId id) {
    const std::size_t triangles = body(id).mesh.triangleCount();
    if (budget_ == 0 || triangles == 0) return;
    const std::size_t stride = (triangles + budget_ - 1) / budget_;
    const TriangleSet& highlighted = highlighted_.try_emplace(id, body(id)).first->second;
    Marker marker = triangleList(report_.bodies[id].name, surfaceId(report_, id));
    for (std::size_t t = 0; t < triangles; t += stride) {
      const auto triangle = static_cast<std::uint32_t>(t);
      if (!highlighted.has(triangle)) addTriangle(id, triangle, &marker);
    }
    marker.color = color(0.45F, 0.7F, 1, options_.surface_alpha);
    add(std::move(marker));
  }

  void add(Marker marker) {
    if (marker.points.empty()) return;
    budget_ -= marker.points.size() / 3;
    markers_.push_back(std::move(marker));
  }

  const CycleReport& report_;
  const MarkerOptions& options_;
  std::size_t budget_;  // triangles that may still be drawn
  std::map<BodyId, TriangleSet> highlighted_;
  std::vector<Marker> markers_;
};

}  // namespace

visualization_msgs::MarkerArray ContactMarkers::make(const CycleReport& report) {
  visualization_msgs::MarkerArray array;
  const auto remove = [&](const std::string& name, std::int32_t id, int action) {
    Marker marker;
    marker.header = report.header;
    marker.ns = name;
    marker.id = id;
    marker.action = action;
    marker.pose.orientation.w = 1;
    array.markers.push_back(std::move(marker));
  };
  if (!std::exchange(cleared_, true)) remove("", 0, Marker::DELETEALL);

  // Of this cycle, what was drawn before and is not now.
  std::set<std::pair<std::string, std::int32_t>> gone;
  const auto mayGo = [&](std::pair<std::string, std::int32_t> key) {
    if (drawn_.count(key) > 0) gone.insert(std::move(key));
  };
  for (const MonitoredPair& pair : report.pairs) {
    if (!isOfCycle(report.bodies, pair)) continue;
    mayGo({contactName(report, pair.a, pair.b), contactId(report, pair.a, pair.b)});
  }
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    if (report.bodies[id].triggered) mayGo({report.bodies[id].name, surfaceId(report, id)});
  }
  std::vector<Marker> markers = MarkerBuilder(report, options_).build();
  for (const Marker& marker : markers) {
    gone.erase({marker.ns, marker.id});
    drawn_.insert({marker.ns, marker.id});
  }
  for (const auto& [name, id] : gone) {
    remove(name, id, Marker::DELETE);
    drawn_.erase({name, id});
  }
  array.markers.insert(array.markers.end(), std::make_move_iterator(markers.begin()),
                       std::make_move_iterator(markers.end()));
  return array;
}

bool MarkerRate::isDue(const CycleReport& report, SteadyTime now) {
  const auto hasNone = [&](const BodyStatus& body) {
    const auto last = last_.find(body.name);
    return body.triggered && (last == last_.end() || now - last->second >= period_);
  };
  if (std::none_of(report.bodies.begin(), report.bodies.end(), hasNone)) return false;
  for (const BodyStatus& body : report.bodies) {
    if (body.triggered) last_[body.name] = now;
  }
  return true;
}

}  // namespace deformable_contact_monitor
