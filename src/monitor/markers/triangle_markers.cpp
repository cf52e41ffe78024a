// Draws triangles: those in contact, those that passed, those that are held, and the objects'
// surfaces.
//
// Contacts come first. What they leave of max_triangles goes to triangles that passed, then to held
// ones, and the rest to the surfaces, which are decimated until they fit.
#include "monitor/markers/triangle_markers.h"

#include <algorithm>
#include <utility>

#include "core/common/posed_body.h"
#include "core/predicates/triangle.h"
#include "monitor/state/rejected_sides.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;

// Colors of links and objects differ in each kind of marker: near ones are pale, passed ones
// violet.
std_msgs::ColorRGBA nearColor(BodyKind kind, float alpha) {
  return kind != BodyKind::kDeformable ? makeColor(1, 0.7F, 0.7F, alpha)
                                       : makeColor(1, 0.95F, 0.7F, alpha);
}

std_msgs::ColorRGBA passedColor(BodyKind kind, float alpha) {
  return kind != BodyKind::kDeformable ? makeColor(0.8F, 0, 1, alpha)
                                       : makeColor(0.5F, 0.2F, 1, alpha);
}

// Holds triangles of one body, each once. A flag per triangle makes insertion fast: there are many
// contacts, and the next cycle waits for the markers.
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

// Holds the triangles to draw for one pair of bodies. For a body with itself, all are in `a`.
struct Drawn {
  TriangleSet a, b;
  std::size_t touching_a = 0, touching_b = 0;  // so many touch; the rest are near
  std::size_t size() const { return a.list().size() + b.list().size(); }
};

// The ids of a pair's bodies, in the order of its contacts.
using BodyPair = std::pair<BodyId, BodyId>;

// Adds the triangle unless a corner is not finite, which rviz rejects. Returns whether it did.
bool addTriangle(const Triangle& triangle, Marker* marker) {
  if (!isFinite(triangle)) return false;
  for (const Vec3f& corner : triangle.v) marker->points.push_back(toPoint(corner));
  return true;
}

// Adds the triangles of one cycle's contacts, and remembers them: a surface leaves them out.
class ContactTriangles {
 public:
  ContactTriangles(const CycleReport& report, const MarkerOptions& options)
      : report_(report), options_(options) {}

  // Adds the contacts at the stamp. Returns how many triangles were added.
  std::size_t add(std::vector<Marker>* markers) {
    std::size_t count = 0;
    for (const auto& [pair, drawn] : drawnPairs()) {
      const auto& [a, b] = pair;
      Marker marker =
          makeMarker(report_, options_.lifetime_s, pairKey(report_, a, b), Marker::TRIANGLE_LIST);
      marker.points.reserve(3 * drawn.size());
      marker.colors.reserve(3 * drawn.size());
      highlight(a, drawn.a, drawn.touching_a, &marker);
      highlight(b, drawn.b, drawn.touching_b, &marker);
      marker.color = contactColor(BodyKind::kLink, options_.alpha);
      if (marker.points.empty()) continue;
      count += marker.points.size() / 3;
      markers->push_back(std::move(marker));
    }
    return count;
  }

  // Adds at most `most` triangles that touched during the cycle's steps and are not drawn yet.
  // Returns how many were added.
  std::size_t addPassed(std::size_t most, std::vector<Marker>* markers) {
    std::map<BodyPair, Marker> of_pair;
    std::size_t count = 0;
    for (const SweepReport& sweep : report_.sweeps) {
      if (sweep.result == nullptr) continue;
      for (const TrianglePair& c : sweep.result->detection.contacts) {
        Marker& marker = of_pair[{c.body_a, c.body_b}];
        for (const auto& [id, triangle] :
             {std::pair(c.body_a, c.triangle_a), std::pair(c.body_b, c.triangle_b)}) {
          if (count < most && addPassedTriangle(id, triangle, &marker)) ++count;
        }
      }
    }
    for (auto& [pair, drawn] : of_pair) {
      if (drawn.points.empty()) continue;
      Marker marker =
          makeMarker(report_, options_.lifetime_s,
                     pairKey(report_, pair.first, pair.second, kPassed), Marker::TRIANGLE_LIST);
      marker.points = std::move(drawn.points);
      marker.colors = std::move(drawn.colors);
      marker.color = passedColor(BodyKind::kLink, options_.alpha);
      markers->push_back(std::move(marker));
    }
    return count;
  }

  // Adds at most `most` held triangles of a body that are not drawn yet. Returns how many were
  // added.
  std::size_t addHeld(BodyId id, std::size_t most, std::vector<Marker>* markers) {
    const std::vector<PartId>& pieces = body(id).parts;
    const BodyStatus& status = report_.bodies[id];
    if (pieces.empty() || status.parts == nullptr || status.parts->heldPart() == 0) return 0;
    Marker marker =
        makeMarker(report_, options_.lifetime_s, heldKey(report_, id), Marker::TRIANGLE_LIST);
    marker.color = makeColor(0.2F, 0.75F, 0.3F, options_.alpha);
    TriangleSet& highlighted = highlighted_.try_emplace(id, body(id)).first->second;
    const PosedBody posed(body(id));
    for (std::uint32_t t = 0; t < pieces.size() && marker.points.size() < 3 * most; ++t) {
      if (!status.parts->isHeld(pieces[t]) || highlighted.has(t)) continue;
      if (addTriangle(posed.triangle(t), &marker)) highlighted.insert(t);
    }
    const std::size_t count = marker.points.size() / 3;
    if (count > 0) markers->push_back(std::move(marker));
    return count;
  }

  // Returns the triangles of a body that were added; null if there are none.
  const TriangleSet* highlighted(BodyId id) const {
    const auto of_body = highlighted_.find(id);
    return of_body == highlighted_.end() ? nullptr : &of_body->second;
  }

 private:
  const Body& body(BodyId id) const { return report_.scene->body(id); }

  // Calls visit(contact, triangles of its pair of bodies) for the contacts that touch, or for those
  // that are near. Contacts of one pair mostly follow one another, so the last pair is kept.
  template <class Visit>
  void forEachContact(bool touching, std::map<BodyPair, Drawn>* pairs, const Visit& visit) const {
    auto of_last = pairs->end();
    for (std::size_t i = 0; i < report_.result->contacts.size(); ++i) {
      if (report_.result->touches(i) != touching) continue;
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

  // Selects what to draw: the same number of triangles for each pair of bodies, touching ones
  // first.
  std::map<BodyPair, Drawn> drawnPairs() const {
    const bool any_near = !report_.result->separations_m.empty();
    std::map<BodyPair, Drawn> pairs;
    forEachContact(true, &pairs, [](const TrianglePair&, Drawn*) {});
    if (any_near) forEachContact(false, &pairs, [](const TrianglePair&, Drawn*) {});
    const std::size_t most = pairs.empty() ? 0 : options_.max_triangles / pairs.size();
    const auto draw = [most](const TrianglePair& c, Drawn* drawn) {
      if (drawn->size() + 2 > most) return;
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

  // Adds the triangles in the color of their body's kind, paler from number `touching` on.
  void highlight(BodyId id, const TriangleSet& triangles, std::size_t touching, Marker* marker) {
    TriangleSet& highlighted = highlighted_.try_emplace(id, body(id)).first->second;
    const BodyKind kind = report_.bodies[id].kind;
    const PosedBody posed(body(id));
    for (std::size_t i = 0; i < triangles.list().size(); ++i) {
      const std::uint32_t triangle = triangles.list()[i];
      if (!addTriangle(posed.triangle(triangle), marker)) continue;
      marker->colors.insert(
          marker->colors.end(), 3,
          i < touching ? contactColor(kind, options_.alpha) : nearColor(kind, options_.alpha));
      highlighted.insert(triangle);
    }
  }

  // Returns whether the triangle was added: it is finite and was not added before.
  bool addPassedTriangle(BodyId id, std::uint32_t triangle, Marker* marker) {
    TriangleSet& highlighted = highlighted_.try_emplace(id, body(id)).first->second;
    if (highlighted.has(triangle)) return false;
    if (!addTriangle(PosedBody(body(id)).triangle(triangle), marker)) return false;
    marker->colors.insert(marker->colors.end(), 3,
                          passedColor(report_.bodies[id].kind, options_.alpha));
    highlighted.insert(triangle);
    return true;
  }

  const CycleReport& report_;
  const MarkerOptions& options_;
  std::map<BodyId, TriangleSet> highlighted_;
};

// Returns the bodies whose surfaces are drawn, in that order.
std::vector<BodyId> drawnBodies(const CycleReport& report) {
  std::vector<BodyId> drawn, rigid;
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const BodyStatus& body = report.bodies[id];
    if (body.kind == BodyKind::kDeformable && body.triggered) drawn.push_back(id);
    const bool is_posed = !body.stamp.isZero() && body.unknown_because.empty();
    if (body.kind == BodyKind::kRigid && is_posed) rigid.push_back(id);
  }
  drawn.insert(drawn.end(), rigid.begin(), rigid.end());
  return drawn;
}

std_msgs::ColorRGBA surfaceColor(const BodyStatus& body, bool is_known, float alpha) {
  if (!is_known) return makeColor(0.5F, 0.5F, 0.5F, alpha);
  return body.kind == BodyKind::kRigid ? makeColor(0.7F, 0.6F, 0.45F, alpha)
                                       : makeColor(0.45F, 0.7F, 1, alpha);
}

}  // namespace

// The scene holds the last mesh and place of an object that is UNKNOWN, so that is what is drawn.
// Objects that deform come before rigid ones, which are drawn where this cycle posed them.
// Triangles that are drawn as contacts are left out of a whole surface; a decimated one has other
// triangles.
void TriangleMarkers::add(const CycleReport& report, std::vector<Marker>* markers) {
  if (report.scene == nullptr) return;
  ContactTriangles contacts(report, options_);
  std::size_t budget = options_.max_triangles;
  if (report.result != nullptr) budget -= contacts.add(markers);
  budget -= contacts.addPassed(budget, markers);
  for (const BodyId id : drawnBodies(report)) {
    const BodyStatus& body = report.bodies[id];
    const bool is_known = whyUnknown(report, id, options_.rules.tolerated_rejects).empty();
    if (is_known) budget -= contacts.addHeld(id, budget, markers);
    const TriangleSet* const highlighted = contacts.highlighted(id);
    const TriangleMesh& mesh = report.scene->body(id).mesh;
    const std::size_t rest =
        mesh.triangleCount() - (highlighted == nullptr ? 0 : highlighted->list().size());
    const bool is_whole = rest <= budget;
    const HostList<std::uint32_t>& corners =
        is_whole ? mesh.triangles : decimated(report, id, budget);
    Marker marker = makeMarker(
        report, is_known ? options_.lifetime_s : std::max(options_.lifetime_s, kUnknownLifetimeS),
        surfaceKey(report, id), Marker::TRIANGLE_LIST);
    marker.points.reserve(is_whole ? 3 * rest : corners.size());
    marker.color = surfaceColor(body, is_known, options_.surface_alpha);
    const std::vector<PartId>& pieces = report.scene->body(id).parts;
    const bool shows_parts = is_whole && is_known && !pieces.empty() && body.parts != nullptr;
    const PosedBody posed(report.scene->body(id));
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      const auto triangle = static_cast<std::uint32_t>(i / 3);
      // A triangle that is drawn twice flickers.
      if (is_whole && highlighted != nullptr && highlighted->has(triangle)) continue;
      const auto corner = [&](std::size_t k) { return posed.vertex(corners[i + k]); };
      if (!addTriangle({{corner(0), corner(1), corner(2)}}, &marker) || !shows_parts) continue;
      const PartId piece = pieces[triangle];
      marker.colors.insert(marker.colors.end(), 3,
                           piece == 0 ? marker.color : numberColor(piece, options_.surface_alpha));
    }
    if (marker.points.empty()) continue;
    budget -= marker.points.size() / 3;
    markers->push_back(std::move(marker));
  }
}

// Returns the finest resolution that fits into the budget. Resolutions differ by a factor of 3, so
// that a surface does not change, and flicker, with every change in the number of contacts.
const HostList<std::uint32_t>& TriangleMarkers::decimated(const CycleReport& report, BodyId object,
                                                          std::size_t budget) {
  constexpr int kLevels = 4;
  Levels& levels = surfaces_[report.bodies[object].name];
  if (levels.empty()) {
    const auto objects =
        std::count_if(report.bodies.begin(), report.bodies.end(),
                      [](const BodyStatus& body) { return body.kind != BodyKind::kLink; });
    // The contacts take one part, each object another one.
    std::size_t limit = options_.max_triangles / (static_cast<std::size_t>(objects) + 1);
    for (int i = 0; i < kLevels && limit > 0; ++i, limit /= 3) levels.emplace_back(limit);
  }
  for (DecimatedSurface& level : levels) {
    const HostList<std::uint32_t>& corners = level.triangles(report.scene->body(object).mesh);
    if (corners.size() / 3 <= budget) return corners;
  }
  return nothing_;
}

}  // namespace deformable_contact_monitor
