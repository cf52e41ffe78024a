// The definition of a contact on CGAL's exact predicates: what every detector is held against.
#include "cgal_oracle.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <cmath>

#include "core/rules/posed_vertex.h"
#include "exact_distance.h"

namespace deformable_contact_monitor {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using CgalTriangle = Kernel::Triangle_3;
using Segment = Kernel::Segment_3;

Point toPoint(const Vec3f& v) { return {v.x, v.y, v.z}; }

CgalTriangle toTriangle(const OracleTriangle& t) {
  return {toPoint(t[0]), toPoint(t[1]), toPoint(t[2])};
}

bool isDegenerate(const OracleTriangle& t) {
  return CGAL::collinear(toPoint(t[0]), toPoint(t[1]), toPoint(t[2]));
}

// The edge opposite to a vertex at `apex`, which is one of t's three distinct vertices.
Segment oppositeEdge(const OracleTriangle& t, const Vec3f& apex) {
  const int k = t[0] == apex ? 0 : (t[1] == apex ? 1 : 2);
  return {toPoint(t[(k + 1) % 3]), toPoint(t[(k + 2) % 3])};
}

bool contains(const std::vector<Vec3f>& points, const Vec3f& p) {
  return std::find(points.begin(), points.end(), p) != points.end();
}

// One finite triangle of the scene.
struct Item {
  std::uint32_t body, triangle;
  OracleTriangle received;  // body frame
  OracleTriangle posed;     // scene frame
};

std::vector<Item> finiteTriangles(const Scene& scene) {
  std::vector<Item> items;
  for (std::uint32_t b = 0; b < scene.bodyCount(); ++b) {
    const Body& body = scene.body(b);
    for (std::uint32_t t = 0; t < body.mesh.triangleCount(); ++t) {
      Item item{b, t, {}, {}};
      bool finite = true;
      for (int k = 0; k < 3; ++k) {
        const float* v = &body.mesh.vertices[3 * std::size_t{body.mesh.triangles[3 * t + k]}];
        item.received[k] = {v[0], v[1], v[2]};
        item.posed[k] =
            body.pose.isIdentity() ? item.received[k] : apply(body.pose, item.received[k]);
        const Vec3f& p = item.posed[k];
        finite = finite && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
      }
      if (finite) items.push_back(item);
    }
  }
  return items;
}

// The distinct vertices that two triangles share as received, in the scene frame.
std::vector<Vec3f> sharedPoints(const Item& a, const Item& b) {
  std::vector<Vec3f> shared;
  if (a.body != b.body) return shared;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (a.received[i] == b.received[j] && !contains(shared, a.posed[i])) {
        shared.push_back(a.posed[i]);
      }
    }
  }
  return shared;
}

// Calls visit(a, b) for every enabled pair with overlapping closed boxes, in no order.
template <typename Visit>
void forEachBoxPair(const Scene& scene, const std::vector<Item>& items, const Visit& visit) {
  using Box = CGAL::Box_intersection_d::Box_with_handle_d<double, 3, const Item*>;
  std::vector<Box> boxes;
  boxes.reserve(items.size());
  for (const Item& item : items) {
    double low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
      const auto range =
          std::minmax({item.posed[0][axis], item.posed[1][axis], item.posed[2][axis]});
      low[axis] = range.first;
      high[axis] = range.second;
    }
    boxes.emplace_back(low, high, &item);
  }
  CGAL::box_self_intersection_d(
      boxes.begin(), boxes.end(),
      [&](const Box& a, const Box& b) {
        if (scene.pairEnabled(a.handle()->body, b.handle()->body)) visit(*a.handle(), *b.handle());
      },
      std::ptrdiff_t{10}, CGAL::Box_intersection_d::CLOSED);
}

}  // namespace

bool meetBeyondByPredicates(const OracleTriangle& a, const OracleTriangle& b,
                            const std::vector<Vec3f>& shared) {
  if (isDegenerate(a) || isDegenerate(b)) return meetBeyondByConstruction(a, b, shared);
  if (shared.empty()) return CGAL::do_intersect(toTriangle(a), toTriangle(b));
  if (shared.size() == 1) {
    // A common point other than the apex lies on a segment from it that leaves one of the
    // triangles through the edge opposite.
    return CGAL::do_intersect(oppositeEdge(a, shared[0]), toTriangle(b)) ||
           CGAL::do_intersect(oppositeEdge(b, shared[0]), toTriangle(a));
  }
  for (const Vec3f& v : b) {
    // Two planes meet in the shared edge's line, and each triangle has only the edge there.
    if (!CGAL::coplanar(toPoint(a[0]), toPoint(a[1]), toPoint(a[2]), toPoint(v))) return false;
  }
  return meetBeyondByConstruction(a, b, shared);
}

std::vector<TrianglePair> oracleContacts(const Scene& scene, AdjacentPairs adjacent) {
  const std::vector<Item> items = finiteTriangles(scene);
  std::vector<TrianglePair> contacts;
  forEachBoxPair(scene, items, [&](const Item& a, const Item& b) {
    const std::vector<Vec3f> shared = sharedPoints(a, b);
    if (!shared.empty() && adjacent == AdjacentPairs::kSkip) return;
    if (!meetBeyondByPredicates(a.posed, b.posed, shared)) return;
    const bool in_order = std::make_pair(a.body, a.triangle) < std::make_pair(b.body, b.triangle);
    const Item& first = in_order ? a : b;
    const Item& second = in_order ? b : a;
    contacts.push_back({first.body, first.triangle, second.body, second.triangle});
  });
  std::sort(contacts.begin(), contacts.end());
  return contacts;
}

std::size_t oracleBoxPairs(const Scene& scene) {
  const std::vector<Item> items = finiteTriangles(scene);
  std::size_t count = 0;
  forEachBoxPair(scene, items,
                 [&](const Item& a, const Item& b) { count += sharedPoints(a, b).empty(); });
  return count;
}

double oracleDistance(const Triangle& a, const Triangle& b) {
  const CgalTriangle p = toTriangle({a.v[0], a.v[1], a.v[2]});
  const CgalTriangle q = toTriangle({b.v[0], b.v[1], b.v[2]});
  return CGAL::do_intersect(p, q) ? 0 : exactDistance(a, b);
}

}  // namespace deformable_contact_monitor
