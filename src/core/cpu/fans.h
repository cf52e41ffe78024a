// Certifies the fans of vertices, the last part of the stage `transform`.
//
// A fan is the ring of triangles around a vertex. Where a fan is certified
// (predicates/vertex_fan.h), no two of its triangles can meet beyond what they share, so that all
// pairs of them are decided at once. Four fans are checked at a time, one in each vector lane.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/lane_triangle.h"
#include "core/cpu/transform.h"
#include "core/export.h"
#include "core/scene.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// The ring of vertex v goes from ring[begin[v]] up to ring[begin[v + 1]]. Any two entries that
// follow one another form a triangle of the mesh with v, in the mesh's orientation, and the mesh
// has no other triangle with v. If a vertex has no such ring, is in too many triangles, or in none,
// its ring begins with v itself.
struct VertexFans {
  std::vector<std::uint32_t> begin;  // per vertex, and one more; empty: too large for 32 bits
  std::vector<std::uint32_t> ring;   // indices of vertices
};

// Returns the rings of a valid mesh. Compares vertices by index, not by coordinates.
DCM_EXPORT VertexFans vertexFans(const TriangleMesh& mesh);

// Lists the vertices of a mesh that have fans in groups of four whose fans are alike: equally many
// ring points, and either all closed or all open. The last group of a kind is filled up with its
// last vertex.
std::vector<std::uint32_t> foursAlike(const VertexFans& fans);

// Checks four such vertices; each lane has the same answer, bit for bit, as isFanCertified() gives
// for that vertex. `vertices` are all vertices of the mesh, transformed.
IntLanes areFansCertified(const VertexFans& fans, const std::uint32_t four[4],
                          const Vec3f* vertices);

// Certifies the fans of all bodies that have contacts with themselves. It keeps the groups of four
// of a body until the body's topology changes.
class FanCertifier {
 public:
  // Sets kFanCertified in the ids of vertices whose fans are certified. `set` was just built from
  // the scene. Once the limit is over, some vertices are left out, which costs time later but
  // changes no result.
  void certify(const Scene& scene, WorkingSet& set, const CycleLimit& limit);

 private:
  struct BodyFans {
    std::uint64_t topology_revision = 0;  // no body has this one
    VertexFans fans;
    std::vector<std::uint32_t> fours;  // its vertices in the order of foursAlike()
  };

  void markRepeated(const std::uint32_t* id, std::uint32_t first, std::uint32_t count,
                    const CycleLimit& limit);
  void certifyBody(const BodyFans& body, std::uint32_t first, std::uint32_t count,
                   const CycleLimit& limit, WorkingSet& set);

  std::vector<BodyFans> bodies_;
  std::vector<char>
      repeated_;  // per vertex of a body: whether another vertex equals it; empty if there is none
};

}  // namespace deformable_contact_monitor
