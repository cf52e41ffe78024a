#include "containment_oracle.h"

#include <CGAL/determinant.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "cgal_oracle.h"
#include "core/common/posed_body.h"
#include "exact_points.h"

namespace deformable_contact_monitor {
namespace {

using Key = std::array<float, 3>;

Key keyOf(const Vec3f& v) { return {v.x + 0.0F, v.y + 0.0F, v.z + 0.0F}; }  // -0 becomes 0

// A component, and the sets of its triangles that are closed surfaces: all of them, or one of each
// that have the same vertices.
struct Component {
  std::vector<std::uint32_t> triangles;
  std::vector<std::vector<std::uint32_t>> surfaces;
};

// Edges of the triangle, of two different points each.
std::vector<std::pair<Key, Key>> edgesOf(const Triangle& t) {
  std::vector<std::pair<Key, Key>> edges;
  for (int k = 0; k < 3; ++k) {
    const Vec3f &u = t.v[k], &v = t.v[(k + 1) % 3];
    if (isFinite(u) && isFinite(v) && u != v) edges.push_back(std::minmax(keyOf(u), keyOf(v)));
  }
  return edges;
}

bool isClosed(const PosedBody& body, const std::vector<std::uint32_t>& triangles) {
  std::map<std::pair<Key, Key>, std::size_t> count;
  for (const std::uint32_t t : triangles) {
    const auto edges = edgesOf(body.received(t));
    for (const auto& edge : edges) count[edge] += edges.size() == 3 ? 1 : 0;
  }
  return std::all_of(count.begin(), count.end(), [](const auto& of) { return of.second % 2 == 0; });
}

std::vector<std::vector<std::uint32_t>> surfacesOf(const PosedBody& body,
                                                   const std::vector<std::uint32_t>& triangles) {
  std::map<std::set<Key>, std::uint32_t> different;
  for (const std::uint32_t t : triangles) {
    const Triangle of = body.received(t);
    different[{keyOf(of.v[0]), keyOf(of.v[1]), keyOf(of.v[2])}] = t;
  }
  std::vector<std::uint32_t> once;
  for (const auto& [corners, t] : different) once.push_back(t);
  std::vector<std::vector<std::uint32_t>> surfaces;
  if (isClosed(body, triangles)) surfaces.push_back(triangles);
  if (once.size() < triangles.size() && isClosed(body, once)) surfaces.push_back(once);
  return surfaces;
}

std::vector<Component> componentsOf(const Body& body) {
  const PosedBody posed(body);
  const auto count = static_cast<std::uint32_t>(body.mesh.triangleCount());
  std::map<std::pair<Key, Key>, std::vector<std::uint32_t>> of_edge;
  for (std::uint32_t t = 0; t < count; ++t) {
    for (const auto& edge : edgesOf(posed.received(t))) of_edge[edge].push_back(t);
  }
  const auto rejected = [&](std::uint32_t t) { return !isFinite(posed.received(t)); };
  std::vector<bool> seen(count, false);
  std::vector<Component> components;
  for (std::uint32_t first = 0; first < count; ++first) {
    if (seen[first] || rejected(first)) continue;
    seen[first] = true;
    Component component;
    std::vector<std::uint32_t> to_visit{first};
    std::set<std::pair<Key, Key>> edges;
    while (!to_visit.empty()) {
      const std::uint32_t t = to_visit.back();
      to_visit.pop_back();
      component.triangles.push_back(t);
      for (const auto& edge : edgesOf(posed.received(t))) {
        edges.insert(edge);
        for (const std::uint32_t next : of_edge[edge]) {
          if (seen[next] || rejected(next)) continue;
          seen[next] = true;
          to_visit.push_back(next);
        }
      }
    }
    const bool beside_rejected = std::any_of(edges.begin(), edges.end(), [&](const auto& edge) {
      return std::any_of(of_edge[edge].begin(), of_edge[edge].end(), rejected);
    });
    if (!beside_rejected) component.surfaces = surfacesOf(posed, component.triangles);
    components.push_back(std::move(component));
  }
  return components;
}

exact::Rational determinant(const exact::Vector& a, const exact::Vector& b,
                            const exact::Vector& c) {
  return CGAL::determinant(a, b, c);
}

// Returns 1 if the ray from p crosses the triangle, 0 if not, and -1 if it meets the line of an
// edge.
int crosses(const exact::Point& p, const exact::Vector& ray, const Triangle& t) {
  const exact::Point corner[3] = {exact::toPoint(t.v[0]), exact::toPoint(t.v[1]),
                                  exact::toPoint(t.v[2])};
  if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) return 0;
  CGAL::Sign side[3];
  for (int k = 0; k < 3; ++k) {
    side[k] = CGAL::sign(determinant(ray, corner[k] - p, corner[(k + 1) % 3] - p));
    if (side[k] == CGAL::ZERO) return -1;
  }
  if (side[0] != side[1] || side[1] != side[2]) return 0;
  const exact::Vector normal = CGAL::cross_product(corner[1] - corner[0], corner[2] - corner[0]);
  return CGAL::sign(normal * (corner[0] - p)) == CGAL::sign(normal * ray);
}

// Returns whether the part is inside the surface. It casts rays from random points of the part.
bool isInside(const PosedBody& inner, const Component& part, const PosedBody& body,
              const std::vector<std::uint32_t>& surface) {
  static std::mt19937 random(5);
  const auto number = [] { return static_cast<int>(random() % 2000003) - 1000001; };
  for (;;) {
    const Triangle of = inner.triangle(part.triangles[random() % part.triangles.size()]);
    const exact::Rational u(static_cast<int>(random() % 1000)),
        v(static_cast<int>(random() % 1000));
    const exact::Point corner = exact::toPoint(of.v[0]);
    const exact::Point p = corner + (exact::toPoint(of.v[1]) - corner) * (u / 2000) +
                           (exact::toPoint(of.v[2]) - corner) * (v / 2000);
    const exact::Vector ray(number(), number(), number());
    int crossed = 0;
    bool tie = false;
    for (const std::uint32_t t : surface) {
      const int answer = crosses(p, ray, body.triangle(t));
      tie = tie || answer < 0;
      crossed += answer;
    }
    if (!tie) return crossed % 2 != 0;
  }
}

}  // namespace

std::vector<OraclePart> oracleInside(const Scene& scene) {
  std::set<std::array<std::uint32_t, 4>> contacts;
  for (const TrianglePair& c : oracleContacts(scene, AdjacentPairs::kSkip)) {
    contacts.insert({c.body_a, c.triangle_a, c.body_b, c.triangle_b});
    contacts.insert({c.body_b, c.triangle_b, c.body_a, c.triangle_a});
  }
  std::vector<std::vector<Component>> components;
  for (const Body& body : scene.bodies()) components.push_back(componentsOf(body));
  const auto touches = [&](BodyId a, const Component& p, BodyId b, const Component& q) {
    for (const std::uint32_t s : p.triangles) {
      for (const std::uint32_t t : q.triangles) {
        if (contacts.count({a, s, b, t}) > 0) return true;
      }
    }
    return false;
  };
  std::vector<OraclePart> parts;
  for (BodyId a = 0; a < scene.bodyCount(); ++a) {
    for (BodyId b = 0; b < scene.bodyCount(); ++b) {
      if (a == b || !scene.pairEnabled(a, b)) continue;
      const PosedBody inner(scene.body(a)), outer(scene.body(b));
      for (const Component& p : components[a]) {
        const auto holds = [&](const Component& q) {
          return !touches(a, p, b, q) &&
                 std::any_of(q.surfaces.begin(), q.surfaces.end(),
                             [&](const auto& s) { return isInside(inner, p, outer, s); });
        };
        if (!std::any_of(components[b].begin(), components[b].end(), holds)) continue;
        parts.push_back({a, b, *std::min_element(p.triangles.begin(), p.triangles.end())});
      }
    }
  }
  std::sort(parts.begin(), parts.end());
  return parts;
}

}  // namespace deformable_contact_monitor
