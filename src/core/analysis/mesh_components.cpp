// Finds the components of a mesh in three steps: equal vertices are welded, triangles that share an
// edge are joined with a union-find, and a component is marked as open if one of its edges belongs
// to one triangle. Components with edges of more than two triangles are left to surface_layers.h.
#include "core/analysis/mesh_components.h"

#include <algorithm>
#include <array>

#include "core/analysis/surface_layers.h"
#include "core/analysis/union_find.h"
#include "core/rules/vertex_hash.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kNone = MeshComponents::kNone;

using Corners = std::array<std::uint32_t, 3>;

// Returns the welded vertices of a triangle.
Corners cornersOf(const TriangleMesh& mesh, const std::vector<std::uint32_t>& vertex,
                  std::size_t t) {
  const std::uint32_t* corner = &mesh.triangles[3 * t];
  return {vertex[corner[0]], vertex[corner[1]], vertex[corner[2]]};
}

// Returns whether the triangle has a vertex that is not finite.
bool isRejected(const Corners& c) { return c[0] == kNone || c[1] == kNone || c[2] == kNone; }

bool hasThreeVertices(const Corners& c) { return c[0] != c[1] && c[1] != c[2] && c[2] != c[0]; }

// A hash table of the edges of a mesh, with open addressing. The key of an edge holds its two
// welded vertices, the lesser one in the upper half. The table is at most half full.
class EdgeTable {
 public:
  struct Edge {
    std::uint64_t key = kFree;
    std::uint32_t triangle = 0;  // a triangle with this edge
    std::uint32_t count = 0;     // how many triangles with three different vertices have it
  };

  explicit EdgeTable(std::size_t most_edges) {
    std::size_t size = 16;
    while (size < 2 * most_edges) size *= 2;
    edges_.resize(size);
  }

  // Returns the place of edge k of the triangle. Its key is kFree if the edge is new.
  Edge& find(const Corners& c, int k, std::uint64_t* key) {
    const std::uint32_t u = c[k], v = c[(k + 1) % 3];
    *key = std::uint64_t{std::min(u, v)} << 32U | std::max(u, v);
    std::size_t slot = mixed(*key) & (edges_.size() - 1);
    while (edges_[slot].key != kFree && edges_[slot].key != *key) {
      slot = (slot + 1) & (edges_.size() - 1);
    }
    return edges_[slot];
  }

  const std::vector<Edge>& edges() const { return edges_; }

  static constexpr std::uint64_t kFree =
      ~std::uint64_t{0};  // the key of no edge: its ends would be equal

 private:
  std::vector<Edge> edges_;
};

// Joins the triangle with the triangles that share an edge with it.
void addTriangle(const Corners& c, std::uint32_t t, EdgeTable* table, UnionFind* joined) {
  const bool counts = hasThreeVertices(c);
  for (int k = 0; k < 3; ++k) {
    if (c[k] == c[(k + 1) % 3]) continue;
    std::uint64_t key = 0;
    EdgeTable::Edge& edge = table->find(c, k, &key);
    if (edge.key == EdgeTable::kFree) {
      edge.key = key;
      edge.triangle = t;
    }
    joined->join(edge.triangle, t);
    edge.count += counts ? 1 : 0;
  }
}

// Marks the components as open that share an edge with this rejected triangle: their surface has a
// hole where the triangle would be.
void openBesideRejected(const Corners& c, EdgeTable* table, MeshComponents* components) {
  for (int k = 0; k < 3; ++k) {
    if (c[k] == kNone || c[(k + 1) % 3] == kNone) continue;
    std::uint64_t key = 0;
    const EdgeTable::Edge& edge = table->find(c, k, &key);
    if (edge.key == key) components->closed[components->of_triangle[edge.triangle]] = false;
  }
}

// Fills of_triangle, triangles and first. Marks all components as closed surfaces of one layer;
// what differs is found later.
void number(const std::vector<bool>& rejected, UnionFind* joined, MeshComponents* components) {
  const auto count = static_cast<std::uint32_t>(rejected.size());
  std::vector<std::uint32_t>& of = components->of_triangle;
  of.assign(count, kNone);
  components->first.assign(1, 0);
  for (std::uint32_t t = 0; t < count; ++t) {
    if (rejected[t]) continue;
    const std::uint32_t least = joined->find(t);
    if (least == t) {
      of[t] = static_cast<std::uint32_t>(components->first.size() - 1);
      components->first.push_back(0);
    }
    of[t] = of[least];
    ++components->first[of[t] + 1];
  }
  for (std::size_t i = 1; i < components->first.size(); ++i) {
    components->first[i] += components->first[i - 1];
  }
  components->triangles.resize(components->first.back());
  std::vector<std::uint32_t> next(components->first);
  for (std::uint32_t t = 0; t < count; ++t) {
    if (!rejected[t]) components->triangles[next[of[t]]++] = t;
  }
  components->closed.assign(components->first.size() - 1, true);
  components->layers.assign(count, 1);
}

// Sets `closed` and `layers` of a component in which more than two triangles share an edge.
void setLayers(const TriangleMesh& mesh, const std::vector<std::uint32_t>& vertex,
               std::uint32_t component, const CycleLimit& limit, MeshComponents* components) {
  std::vector<SurfaceTriangle> triangles;
  const std::vector<std::uint32_t>& first = components->first;
  for (std::uint32_t i = first[component]; i < first[component + 1]; ++i) {
    const std::uint32_t t = components->triangles[i];
    const Corners corners = cornersOf(mesh, vertex, t);
    if (hasThreeVertices(corners)) triangles.push_back({corners, t});
  }
  const SurfaceLayers layers = findLayers(triangles, limit);
  if (limit.over()) return;
  components->closed[component] = layers.closed;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    components->layers[triangles[i].index] = layers.of[i];
  }
}

}  // namespace

bool BodyComponents::update(const Body& body, const CycleLimit& limit) {
  if (body.topology_revision == topology_revision_ &&
      body.vertices_revision == vertices_revision_) {
    return true;
  }
  const bool same_triangles = body.topology_revision == topology_revision_;
  // Stays 0 if the limit ends the update, so that the next call starts again.
  topology_revision_ = 0;
  if (!weld(body.mesh, limit)) return false;
  if (!same_triangles || new_vertex_ != vertex_) {
    vertex_.swap(new_vertex_);
    if (!build(body.mesh, limit)) return false;
  }
  topology_revision_ = body.topology_revision;
  vertices_revision_ = body.vertices_revision;
  return true;
}

// Finds the least equal vertex for each vertex of the mesh.
bool BodyComponents::weld(const TriangleMesh& mesh, const CycleLimit& limit) {
  identity_.identify(mesh.vertices, new_vertex_, limit);
  if (limit.over()) return false;
  for (std::size_t i = 0; i < new_vertex_.size(); ++i) {
    if (!isFinite(mesh.vertex(i))) new_vertex_[i] = kNone;
  }
  return true;
}

bool BodyComponents::build(const TriangleMesh& mesh, const CycleLimit& limit) {
  constexpr std::uint64_t kStepsALook = 1 << 13;
  const std::size_t count = mesh.triangleCount();
  PacedLimit pace(limit, kStepsALook);
  EdgeTable table(3 * count);
  UnionFind joined(count);
  std::vector<bool> rejected(count);
  for (std::size_t t = 0; t < count; ++t) {
    if (pace.over()) return false;
    const Corners corners = cornersOf(mesh, vertex_, t);
    rejected[t] = isRejected(corners);
    if (!rejected[t]) addTriangle(corners, static_cast<std::uint32_t>(t), &table, &joined);
  }
  number(rejected, &joined, &components_);
  std::vector<bool> has_layers(components_.count(), false);
  for (const EdgeTable::Edge& edge : table.edges()) {
    if (edge.count == 1) components_.closed[components_.of_triangle[edge.triangle]] = false;
    if (edge.count > 2) has_layers[components_.of_triangle[edge.triangle]] = true;
  }
  for (std::uint32_t c = 0; c < components_.count() && !limit.over(); ++c) {
    if (has_layers[c]) setLayers(mesh, vertex_, c, limit, &components_);
  }
  for (std::size_t t = 0; t < count; ++t) {
    if (rejected[t]) openBesideRejected(cornersOf(mesh, vertex_, t), &table, &components_);
  }
  return !limit.over();
}

}  // namespace deformable_contact_monitor
