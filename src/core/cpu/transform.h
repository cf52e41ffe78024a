// Stage `pose`: from the scene to the triangles that can be in contact at all.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/index.h"
#include "core/common/parallel.h"
#include "core/cpu/body_boxes.h"
#include "core/cpu/primitive.h"
#include "core/cpu/vertex_identity.h"
#include "core/detector.h"
#include "core/predicates/aabb.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Triangles of one cycle, in ascending (body, triangle) order. Boxes are of the posed float32
// vertices, grown by the body's margin; in swept motion, of all that they pass without the common
// motion, grown by the body's pad.
struct WorkingSet {
  std::vector<Vec3f> vertices;  // scene frame [m], of all bodies that take part
  std::vector<Vec3f> earlier;   // the same at the step's beginning; in swept motion only
  Vec3f common_motion;          // [m]; in swept motion only
  // Per vertex: equal iff of one body and equal as received; maybe with kFanCertified.
  std::vector<std::uint32_t> vertex_id;
  std::vector<std::uint32_t> corners;       // three indices into `vertices` per triangle
  std::vector<std::uint32_t> body;          // per triangle
  std::vector<std::uint32_t> triangle;      // per triangle: its id in the body
  std::vector<Aabb> boxes;                  // per triangle
  std::vector<std::uint32_t> first_vertex;  // per body: where its vertices begin in `vertices`

  std::size_t size() const { return triangle.size(); }
  const std::uint32_t* cornersOf(TriangleIndex t) const {
    return &corners[3 * std::size_t{t.value}];
  }
  // With vertices a, b and c.
  template <class Hull>
  Hull hullOf(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Triangle now{{vertices[a], vertices[b], vertices[c]}};
    if constexpr (kIsMoving<Hull>) {
      return {{{earlier[a], earlier[b], earlier[c]}}, now};
    } else {
      return now;
    }
  }
  template <class Hull = Triangle>
  Hull posed(TriangleIndex t) const {
    const std::uint32_t* corner = cornersOf(t);
    return hullOf<Hull>(corner[0], corner[1], corner[2]);
  }
  BodyIndex bodyOf(TriangleIndex t) const { return BodyIndex(body[t.value]); }
  const Aabb& box(TriangleIndex t) const { return boxes[t.value]; }
  // Of a triangle's three vertices.
  std::array<std::uint32_t, 3> vertexIds(TriangleIndex t) const {
    const std::uint32_t* corner = cornersOf(t);
    return {vertex_id[corner[0]], vertex_id[corner[1]], vertex_id[corner[2]]};
  }
};

// Finds the working set; keeps its buffers from call to call.
class WorkingSetBuilder {
 public:
  // A body takes part if its box meets a partner's; a triangle, if its box meets the box of a
  // partner of its body. Adds to counters.rejected, posed and culled. Where the limit was over, the
  // set is of no use. Hull: as in hull.h.
  template <class Hull = Triangle>
  void build(const Scene& scene, WorkingSet& set, Counters& counters,
             const CycleLimit& limit = noLimit());

 private:
  // What one block of a body's triangles contributes; unless every triangle of the body does.
  struct alignas(kOwnLines) Block {
    std::vector<std::uint32_t> triangle;
    std::vector<Aabb> boxes;
    std::uint64_t rejected = 0;
    std::size_t place = 0;  // in the set
  };

  template <class Hull>
  void countLeftOut(const Scene& scene, BodyId id, const CycleLimit& limit,
                    Counters& counters) const;
  template <class Hull>
  void addBody(const Scene& scene, BodyId id, const PartnerBoxes<BoxOf<Hull>>& partners,
               const CycleLimit& limit, WorkingSet& set, Counters& counters);
  void identifyVertices(const Body& body, bool self, bool moving, std::uint32_t first,
                        const CycleLimit& limit, WorkingSet& set);
  template <class Hull>
  void addAllTriangles(const Body& body, BodyId id, const CycleLimit& limit, WorkingSet& set);
  template <class Hull>
  void chooseTriangles(const Body& body, BodyId id, std::uint32_t first,
                       const PartnerBoxes<BoxOf<Hull>>& partners, const CycleLimit& limit,
                       const WorkingSet& set);
  std::uint64_t addChosen(const Body& body, BodyId id, const CycleLimit& limit, WorkingSet& set);

  BodyBoxes body_boxes_;
  VertexIdentity identity_;
  std::vector<std::uint32_t> least_equal_;
  std::vector<std::uint8_t> sides_;  // of a body's vertices
  std::vector<Block> blocks_;
  // The set's, so far; its arrays are as long as they were in the cycle before, or longer.
  std::size_t vertex_count_ = 0, triangle_count_ = 0;
};

}  // namespace deformable_contact_monitor
