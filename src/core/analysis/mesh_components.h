// Which triangles of a mesh hang together, and which of these components are closed surfaces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/vertex_identity.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Triangles hang together that share an edge; vertices with equal coordinates as received are one
// (-0 equals 0), so polygon soups have the components of the welded mesh. Surfaces that share a
// vertex alone are components of their own. Components are numbered by their least triangles.
//
// A component is closed iff each of its edges (of two different vertices) belongs to an even number
// of its triangles (twice to one that has two equal vertices, so that this one counts nowhere), and
// no triangle with a vertex that is not finite shares an edge with it. Then "inside" is defined,
// modulo 2: the sum of its triangles is a chain without a boundary, so that a line which meets the
// surface only within triangles crosses it an even number of times; hence two rays from one point
// cross it equally often, modulo 2. This holds wherever the vertices are: also for surfaces that
// pass through themselves, run along themselves or were rounded together by a pose, and for
// triangles without area, which no such line meets.
struct MeshComponents {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::vector<std::uint32_t> of_triangle;  // kNone: it has a vertex that is not finite
  std::vector<std::uint32_t> triangles;    // by component, ascending
  std::vector<std::uint32_t> first;        // of each component in `triangles`, and the end
  std::vector<bool> closed;

  std::size_t count() const { return closed.size(); }
};

// Of one body, kept from cycle to cycle. One thread at a time.
class BodyComponents {
 public:
  // Brings them up to the body's mesh: nothing is done while that is the same, and little while the
  // same vertices are equal. False if the limit was over before the end.
  bool update(const Body& body, const CycleLimit& limit);

  // As of the last update() that returned true.
  const MeshComponents& get() const { return components_; }

 private:
  bool weld(const TriangleMesh& mesh, const CycleLimit& limit);
  bool build(const TriangleMesh& mesh, const CycleLimit& limit);

  std::uint64_t topology_revision_ = 0, vertices_revision_ = 0;  // of the mesh; 0: of none
  VertexIdentity identity_;
  std::vector<std::uint32_t> vertex_, new_vertex_;  // the least equal one; kNone: not finite
  MeshComponents components_;
};

}  // namespace deformable_contact_monitor
