// Connected components of a mesh, and which of them are closed surfaces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/vertex_identity.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Triangles are connected if they share an edge. Vertices with equal coordinates as received are
// the same (-0 equals 0), so a polygon soup has the components of the welded mesh. Surfaces that
// share only a vertex are different components. Components are numbered by their least triangles.
//
// A component is closed iff each of its edges (between two different vertices) belongs to an even
// number of its triangles, and no triangle with a non-finite vertex shares an edge with it. Where
// more than two triangles share an edge, it may also be closed in layers (surface_layers.h): a mesh
// that has each triangle twice is closed if the mesh with one of each is. A triangle with two equal
// vertices has its edge twice, so it never matters.
//
// "Inside" is well defined for closed components: the triangles of a layer form a chain without a
// boundary, modulo 2. So a line that meets the surface only in the interior of triangles crosses it
// an even number of times, and any two rays from a point cross it equally often, modulo 2. This
// does not depend on where the vertices are. It holds for surfaces that pass through themselves,
// overlap themselves or were rounded together by a pose, and for triangles without area, which no
// such line meets.
struct MeshComponents {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::vector<std::uint32_t> of_triangle;  // kNone: it has a vertex that is not finite
  std::vector<std::uint32_t> triangles;    // by component, ascending
  std::vector<std::uint32_t> first;  // per component: its first place in `triangles`; one more
  std::vector<bool> closed;
  // Per triangle: a bit for each layer of its component that it is in. A point is inside a closed
  // component iff a ray from it crosses an odd number of triangles of some layer.
  std::vector<std::uint32_t> layers;

  std::size_t count() const { return closed.size(); }
};

// Keeps the components of one body from cycle to cycle. One thread at a time.
class BodyComponents {
 public:
  // Updates the components to the body's mesh. Does nothing if the mesh is the same, and little if
  // the same vertices are equal. Returns false if the limit was over before the end.
  bool update(const Body& body, const CycleLimit& limit);

  // Returns the components as the last update() that returned true made them.
  const MeshComponents& get() const { return components_; }

 private:
  bool weld(const TriangleMesh& mesh, const CycleLimit& limit);
  bool build(const TriangleMesh& mesh, const CycleLimit& limit);

  std::uint64_t topology_revision_ = 0, vertices_revision_ = 0;  // of the mesh; 0: there was none
  VertexIdentity identity_;
  std::vector<std::uint32_t> vertex_,
      new_vertex_;  // per vertex: the least equal one; kNone: not finite
  MeshComponents components_;
};

}  // namespace deformable_contact_monitor
