// Draws a cycle's contacts, patches and attached objects as rviz markers.
//
// rviz keeps a marker until it is replaced, deleted or too old. So each class remembers the keys
// that it drew, and deletes those of this cycle's bodies that are not drawn again.
#include "monitor/markers/contact_markers.h"

#include <visualization_msgs/Marker.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <optional>
#include <utility>

#include "core/common/posed_body.h"
#include "core/pair_geometry.h"
#include "core/predicates/aabb.h"
#include "core/vector3.h"
#include "monitor/rules/rule_texts.h"
#include "monitor/state/pair_state.h"
#include "monitor/state/rejected_sides.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;

// A line in the scene's frame [m].
struct Line {
  Vec3f from, to;
};

// Contacts whose triangles lie on one line have no normal.
bool hasNormal(const PairGeometry& geometry) {
  const Vec3f& n = geometry.normal;
  return (geometry.flags & kNormalUndefined) == 0 && (n.x != 0 || n.y != 0 || n.z != 0);
}

Line segmentOf(const PairGeometry& geometry) { return {geometry.point_a, geometry.point_b}; }

// Returns the line from the middle of the segment along the normal.
Line normalOf(const PairGeometry& geometry) {
  const Vec3f &a = geometry.point_a, &b = geometry.point_b, &n = geometry.normal;
  const Vec3f middle{0.5F * a.x + 0.5F * b.x, 0.5F * a.y + 0.5F * b.y, 0.5F * a.z + 0.5F * b.z};
  return {middle,
          {middle.x + kNormalLengthM * n.x, middle.y + kNormalLengthM * n.y,
           middle.z + kNormalLengthM * n.z}};
}

// Collects the lines of one kind by pair of bodies.
class LineLists {
 public:
  LineLists(const CycleReport& report, double lifetime_s, const char* kind, float width_m)
      : report_(report), lifetime_s_(lifetime_s), kind_(kind), width_m_(width_m) {}

  void add(const TrianglePair& pair, const Line& line, const std_msgs::ColorRGBA& from,
           const std_msgs::ColorRGBA& to) {
    if (!isFinite(line.from) || !isFinite(line.to)) return;
    Marker& marker = lists_[{pair.body_a, pair.body_b}];
    marker.points.push_back(toPoint(line.from));
    marker.points.push_back(toPoint(line.to));
    marker.colors.push_back(from);
    marker.colors.push_back(to);
  }

  // Appends one LINE_LIST per pair of bodies, and leaves this empty.
  void moveTo(std::vector<Marker>* markers) {
    for (auto& [pair, lines] : lists_) {
      Marker marker =
          makeMarker(report_, lifetime_s_, pairKey(report_, pair.first, pair.second, kind_),
                     Marker::LINE_LIST);
      marker.scale.x = width_m_;
      marker.color = lines.colors.front();
      marker.points = std::move(lines.points);
      marker.colors = std::move(lines.colors);
      markers->push_back(std::move(marker));
    }
  }

 private:
  const CycleReport& report_;
  const double lifetime_s_;
  const char* const kind_;
  const float width_m_;
  std::map<std::pair<BodyId, BodyId>, Marker> lists_;
};

// Adds segments and normals of the contacts. With many contacts, every stride-th one has lines.
void addLines(const CycleReport& report, const MarkerOptions& options,
              std::vector<Marker>* markers) {
  if (report.scene == nullptr || report.result == nullptr) return;
  const DetectionResult& result = *report.result;
  if (result.geometry.size() != result.contacts.size() || result.contacts.empty()) return;
  const std_msgs::ColorRGBA touching = makeColor(0, 0, 0, 1), near = makeColor(0.5F, 0.5F, 0.5F, 1);
  const std_msgs::ColorRGBA root = makeColor(0.3F, 0.9F, 0.3F, 1), tip = makeColor(0, 0.3F, 0, 1);
  LineLists segments(report, options.lifetime_s, kSegments, 0.004F);
  LineLists normals(report, options.lifetime_s, kNormals, 0.002F);
  const std::size_t stride =
      (result.contacts.size() + options.max_triangles - 1) / options.max_triangles;
  for (std::size_t i = 0; i < result.contacts.size(); i += stride) {
    const PairGeometry& geometry = result.geometry[i];
    const std_msgs::ColorRGBA& color = result.touches(i) ? touching : near;
    segments.add(result.contacts[i], segmentOf(geometry), color, color);
    if (hasNormal(geometry)) normals.add(result.contacts[i], normalOf(geometry), root, tip);
  }
  segments.moveTo(markers);
  normals.moveTo(markers);
}

// With a tolerance, two bodies may be in contact although no pair of their triangles is listed.
// Then the two points that witness the contact are all there is to draw.
void addWitnesses(const CycleReport& report, const MarkerOptions& options,
                  std::vector<Marker>* markers) {
  constexpr double kDiameterM = 0.01;
  if (report.result == nullptr || report.result->distances.empty()) return;
  const auto with_triangles = report.result->touchingBodies();
  for (const MonitoredPair& pair : report.pairs) {
    if (!isOfCycle(report.bodies, pair) || with_triangles.count({pair.a, pair.b}) > 0) continue;
    const std::optional<PairBounds> distance = boundsOf(report, pair, report.options.tolerance_m);
    if (!distance || !distance->touches()) continue;
    const BodyDistance& witness = *distance->bounds;
    if (!isFinite(witness.point_a) || !isFinite(witness.point_b)) continue;
    Marker marker = makeMarker(report, options.lifetime_s,
                               pairKey(report, pair.a, pair.b, kWitness), Marker::SPHERE_LIST);
    marker.scale.x = marker.scale.y = marker.scale.z = kDiameterM;
    marker.points = {toPoint(witness.point_a), toPoint(witness.point_b)};
    marker.colors = {contactColor(report.bodies[pair.a].kind, options.alpha),
                     contactColor(report.bodies[pair.b].kind, options.alpha)};
    marker.color = marker.colors.front();
    markers->push_back(std::move(marker));
  }
}

// Adds a line between the nearest points of each pair that is NEAR, and a text with its length. The
// ends of the line have the colors of a contact, so that it shows which end is on the robot.
void addNearest(const CycleReport& report, const MarkerOptions& options,
                std::vector<Marker>* markers) {
  constexpr double kWidthM = 0.006, kTextM = 0.04;
  const std_msgs::ColorRGBA orange = makeColor(0.9F, 0.35F, 0, 1);  // on light and dark ground
  for (const MonitoredPair& pair : report.pairs) {
    const std::optional<NearPoints> near = nearPoints(report, pair, options.rules);
    if (!near || !isFinite(near->point_a) || !isFinite(near->point_b)) continue;
    Marker line = makeMarker(report, options.lifetime_s, pairKey(report, pair.a, pair.b, kNearest),
                             Marker::LINE_LIST);
    line.scale.x = kWidthM;
    line.points = {toPoint(near->point_a), toPoint(near->point_b)};
    line.colors = {contactColor(report.bodies[pair.a].kind, 1),
                   contactColor(report.bodies[pair.b].kind, 1)};
    line.color = line.colors.front();
    Marker text = makeMarker(report, options.lifetime_s, pairKey(report, pair.a, pair.b, kDistance),
                             Marker::TEXT_VIEW_FACING);
    text.scale.z = kTextM;
    text.color = orange;
    const Vec3d middle = (toDouble(near->point_a) + toDouble(near->point_b)) * 0.5;
    text.pose.position = toPoint(middle + Vec3d{0, 0, kTextM});
    char length[32];
    std::snprintf(length, sizeof(length), "%.3g m", static_cast<double>(near->distance_m));
    text.text = length;
    markers->push_back(std::move(line));
    markers->push_back(std::move(text));
  }
}

// Adds the edges of at most `most` triangles, but of one at least.
void addOutlines(const Body& body, const std::vector<std::uint32_t>& triangles, std::size_t most,
                 Marker* marker) {
  const PosedBody posed(body);
  for (std::size_t i = 0; i < std::min(triangles.size(), std::max<std::size_t>(most, 1)); ++i) {
    const Triangle corners = posed.triangle(triangles[i]);
    for (int k = 0; k < 3; ++k) {
      marker->points.push_back(toPoint(corners.v[k]));
      marker->points.push_back(toPoint(corners.v[(k + 1) % 3]));
    }
  }
}

// Adds the outline of at most `most` triangles of the patch, its arrow and its text. Their ids
// follow from the patch's id.
void addPatch(const CycleReport& report, double lifetime_s, const Patch& patch, std::size_t most,
              std::vector<Marker>* markers) {
  constexpr double kLineWidthM = 0.001, kArrowM = 0.05, kTextM = 0.02;
  enum Part : std::int32_t { kOutline, kArrow, kText, kParts };
  constexpr std::uint32_t kMostIds = 0x7fffffffU / kParts;
  const auto start = [&](Part part, std::int32_t type) {
    MarkerKey key = pairKey(report, patch.body_a, patch.body_b, kPatch);
    key.second = static_cast<std::int32_t>(patch.id % kMostIds) * kParts + part;
    Marker& marker = markers->emplace_back(makeMarker(report, lifetime_s, std::move(key), type));
    marker.color = numberColor(patch.id, 1);
    return &marker;
  };
  Marker* const outline = start(kOutline, Marker::LINE_LIST);
  outline->scale.x = kLineWidthM;
  addOutlines(report.scene->body(patch.body_a), patch.triangles_a, most / 2, outline);
  addOutlines(report.scene->body(patch.body_b), patch.triangles_b, most / 2, outline);
  if (dot(patch.normal, patch.normal) > 0) {
    Marker* const arrow = start(kArrow, Marker::ARROW);
    arrow->scale.x = 0.1 * kArrowM;  // diameter of the shaft
    arrow->scale.y = 0.2 * kArrowM;  // diameter of the head
    arrow->scale.z = 0.3 * kArrowM;  // length of the head
    arrow->points = {toPoint(patch.centroid), toPoint(patch.centroid + patch.normal * kArrowM)};
  }
  Marker* const text = start(kText, Marker::TEXT_VIEW_FACING);
  text->scale.z = kTextM;
  text->pose.position = toPoint(patch.centroid);
  text->text = std::to_string(patch.id);
}

// Returns the box of the body's finite vertices, in its pose.
Aabb boxOf(const Body& body) {
  const PosedBody posed(body);
  Aabb box;
  for (std::size_t i = 0; i < body.mesh.vertexCount(); ++i) {
    const Vec3f v = posed.vertex(i);
    if (isFinite(v)) box.include(v);
  }
  return box;
}

// Returns a text over the object; nothing if no vertex of the object is finite. The size of the
// text follows that of the object, within limits that stay readable.
std::optional<Marker> textOver(const CycleReport& report, BodyId id, double lifetime_s,
                               MarkerKey key) {
  constexpr double kTextPart = 0.1;  // height of the text as part of the object's longest side
  constexpr double kLeastTextM = 0.01, kMostTextM = 0.2;
  const Aabb box = boxOf(report.scene->body(id));
  if (box.empty()) return std::nullopt;
  Marker marker = makeMarker(report, lifetime_s, std::move(key), Marker::TEXT_VIEW_FACING);
  const double longest = std::max({double{box.max.x} - box.min.x, double{box.max.y} - box.min.y,
                                   double{box.max.z} - box.min.z});
  marker.scale.z = std::clamp(kTextPart * longest, kLeastTextM, kMostTextM);
  marker.pose.position.x = (double{box.min.x} + box.max.x) / 2;
  marker.pose.position.y = (double{box.min.y} + box.max.y) / 2;
  marker.pose.position.z = box.max.z + marker.scale.z;
  // Legible on rviz's dark ground and on a light one.
  marker.color = makeColor(0.9F, 0.3F, 0.1F, 1);
  return marker;
}

// Adds a text over each object that triggered the cycle and is UNKNOWN.
void addReasons(const CycleReport& report, const MarkerOptions& options,
                std::vector<Marker>* markers) {
  if (report.scene == nullptr) return;
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const BodyStatus& body = report.bodies[id];
    if (body.kind != BodyKind::kDeformable || !body.triggered) continue;
    const std::string why = whyUnknown(report, id, options.rules.tolerated_rejects);
    if (why.empty()) continue;
    std::optional<Marker> text =
        textOver(report, id, std::max(options.lifetime_s, kUnknownLifetimeS), unknownKey(id));
    if (!text) continue;
    const bool is_rejected = body.unknown_because.empty();
    text->text =
        body.name + (is_rejected ? " is UNKNOWN where it does not touch: " : " is UNKNOWN: ");
    text->text += why;
    markers->push_back(std::move(*text));
  }
}

}  // namespace

// Deletions come before additions in the array, as rviz applies them in order.
visualization_msgs::MarkerArray ContactMarkers::make(const CycleReport& report) {
  visualization_msgs::MarkerArray array;
  if (!std::exchange(cleared_, true)) {
    array.markers.push_back(makeRemoval(report, {"", 0}, Marker::DELETEALL));
  }
  std::vector<Marker> markers;
  triangles_.add(report, &markers);
  addLines(report, options_, &markers);
  addWitnesses(report, options_, &markers);
  addNearest(report, options_, &markers);
  addReasons(report, options_, &markers);
  std::set<MarkerKey> gone = drawnOfCycle(report);
  for (const Marker& marker : markers) {
    gone.erase({marker.ns, marker.id});
    drawn_.insert({marker.ns, marker.id});
  }
  for (const MarkerKey& key : gone) {
    array.markers.push_back(makeRemoval(report, key, Marker::DELETE));
    drawn_.erase(key);
  }
  array.markers.insert(array.markers.end(), std::make_move_iterator(markers.begin()),
                       std::make_move_iterator(markers.end()));
  return array;
}

// Returns the markers that earlier cycles drew for this cycle's bodies.
std::set<MarkerKey> ContactMarkers::drawnOfCycle(const CycleReport& report) const {
  std::set<MarkerKey> drawn;
  const auto note = [&](const MarkerKey& key) {
    if (drawn_.count(key) > 0) drawn.insert(key);
  };
  for (const MonitoredPair& pair : report.pairs) {
    if (!isOfCycle(report.bodies, pair)) continue;
    for (const char* const kind :
         {"", kSegments, kNormals, kPassed, kWitness, kNearest, kDistance}) {
      note(pairKey(report, pair.a, pair.b, kind));
    }
  }
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const BodyStatus& body = report.bodies[id];
    if (!body.triggered && (body.kind != BodyKind::kRigid || body.stamp.isZero())) continue;
    note(surfaceKey(report, id));
    note(heldKey(report, id));
    note(unknownKey(id));
  }
  return drawn;
}

// Deletes markers only of this cycle's pairs; those of other pairs belong to other cycles.
void PatchMarkers::add(const CycleReport& report, const std::vector<Patch>* patches,
                       visualization_msgs::MarkerArray* array) {
  if (patches == nullptr && drawn_.empty()) return;
  std::vector<Marker> markers;
  if (patches != nullptr) {
    for (const Patch& patch : *patches) {
      addPatch(report, options_.lifetime_s, patch, options_.max_triangles / patches->size(),
               &markers);
    }
  }
  std::set<std::string> of_cycle;
  for (const MonitoredPair& pair : report.pairs) {
    if (!isOfCycle(report.bodies, pair)) continue;
    of_cycle.insert(pairKey(report, pair.a, pair.b, kPatch).first);
  }
  std::set<MarkerKey> now;
  for (const Marker& marker : markers) now.insert({marker.ns, marker.id});
  for (auto drawn = drawn_.begin(); drawn != drawn_.end();) {
    if (of_cycle.count(drawn->first) == 0 || now.count(*drawn) > 0) {
      ++drawn;
      continue;
    }
    array->markers.push_back(makeRemoval(report, *drawn, Marker::DELETE));
    drawn = drawn_.erase(drawn);
  }
  drawn_.insert(now.begin(), now.end());
  array->markers.insert(array->markers.end(), markers.begin(), markers.end());
}

void addHeldMarkers(const CycleReport& report, double lifetime_s,
                    visualization_msgs::MarkerArray* markers) {
  if (report.scene == nullptr) return;
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const BodyStatus& body = report.bodies[id];
    const auto held = report.attached.find(body.name);
    if (held == report.attached.end() || !body.unknown_because.empty()) continue;
    const bool is_posed = body.kind == BodyKind::kRigid && !body.stamp.isZero();
    if (!is_posed && !body.triggered) continue;
    std::optional<Marker> marker =
        textOver(report, id, lifetime_s, {"held", static_cast<std::int32_t>(id)});
    if (!marker) continue;
    marker->text = "held: " + describeHeld(held->first, held->second);
    markers->markers.push_back(std::move(*marker));
  }
}

// Draws all triggered bodies together, even if only one of them is due: their markers belong to one
// report.
bool MarkerRate::isDue(const CycleReport& report, SteadyTime now) {
  const auto isBodyDue = [&](const BodyStatus& body) {
    const auto last = last_.find(body.name);
    return body.triggered && (last == last_.end() || now - last->second >= period_);
  };
  if (std::none_of(report.bodies.begin(), report.bodies.end(), isBodyDue)) return false;
  for (const BodyStatus& body : report.bodies) {
    if (body.triggered) last_[body.name] = now;
  }
  return true;
}

}  // namespace deformable_contact_monitor
