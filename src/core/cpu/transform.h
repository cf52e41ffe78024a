// Stage `transform`: from the scene to the working set, the triangles that can be in contact at
// all.
//
// It transforms all vertices into the scene frame, gives equal vertices of a body the same id, and
// culls: a body takes part only if its box meets the box of a body that it may touch, and a
// triangle only if its box meets the box of such a body, and if its part takes part.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/index.h"
#include "core/common/parallel.h"
#include "core/common/part_table.h"
#include "core/common/vertex_identity.h"
#include "core/cpu/body_boxes.h"
#include "core/cpu/primitive.h"
#include "core/detector.h"
#include "core/predicates/aabb.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// The triangles of one cycle, in ascending (body, triangle) order, as arrays. Boxes are those of
// the transformed float32 vertices, grown by the body's margin. In continuous detection a box holds
// all points that the triangle passes, without the common motion, grown by the body's motion bound.
struct WorkingSet {
  std::vector<Vec3f> vertices;  // scene frame [m], of all bodies that take part
  std::vector<Vec3f>
      earlier;          // the same at the begin of the time interval; continuous detection only
  Vec3f common_motion;  // [m]; continuous detection only
  // Per vertex: two ids are equal iff the vertices belong to one body and were received with equal
  // coordinates. The bit kFanCertified may be set in addition.
  std::vector<std::uint32_t> vertex_id;
  std::vector<std::uint32_t> corners;       // three indices into `vertices` per triangle
  std::vector<std::uint32_t> body;          // per triangle
  std::vector<std::uint32_t> triangle;      // per triangle: its id in the body
  std::vector<Aabb> boxes;                  // per triangle
  std::vector<std::uint32_t> first_vertex;  // per body: where its vertices begin in `vertices`
  std::shared_ptr<const PartTable> parts;   // null: parts do not matter in this scene
  std::vector<std::uint32_t> part;          // per triangle, if they do: its number in `parts`

  std::size_t size() const { return triangle.size(); }
  const std::uint32_t* cornersOf(TriangleIndex t) const {
    return &corners[3 * std::size_t{t.value}];
  }
  // Returns the primitive with vertices a, b and c.
  template <class Primitive>
  Primitive primitiveOf(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Triangle now{{vertices[a], vertices[b], vertices[c]}};
    if constexpr (kIsMoving<Primitive>) {
      return {{{earlier[a], earlier[b], earlier[c]}}, now};
    } else {
      return now;
    }
  }
  template <class Primitive = Triangle>
  Primitive posed(TriangleIndex t) const {
    const std::uint32_t* corner = cornersOf(t);
    return primitiveOf<Primitive>(corner[0], corner[1], corner[2]);
  }
  BodyIndex bodyOf(TriangleIndex t) const { return BodyIndex(body[t.value]); }
  // Returns whether the pair of two triangles' parts is enabled.
  bool partsEnabled(TriangleIndex a, TriangleIndex b) const {
    return parts == nullptr || parts->pairs().enabled(part[a.value], part[b.value]);
  }
  const Aabb& box(TriangleIndex t) const { return boxes[t.value]; }
  // Returns the ids of a triangle's three vertices.
  std::array<std::uint32_t, 3> vertexIds(TriangleIndex t) const {
    const std::uint32_t* corner = cornersOf(t);
    return {vertex_id[corner[0]], vertex_id[corner[1]], vertex_id[corner[2]]};
  }
};

// Finds the working set. It keeps its buffers from cycle to cycle. One per detector.
class WorkingSetBuilder {
 public:
  // Fills `set`, and adds to counters.rejected (triangles with a vertex that is not finite),
  // counters.posed (transformed) and counters.culled. Once the limit is over, the content of `set`
  // is unspecified.
  template <class Primitive = Triangle>
  void build(const Scene& scene, const Options& options, WorkingSet& set, Counters& counters,
             const CycleLimit& limit = noLimit());

  // Returns DetectionResult::rejected_parts of the scene that build() was last called with.
  const std::vector<RejectedPart>& rejectedParts() const { return rejected_parts_; }

 private:
  // The triangles that one block of a body contributes. It is not used for bodies that contribute
  // all of their triangles.
  struct alignas(kOwnLines) Block {
    std::vector<std::uint32_t> triangle;
    std::vector<Aabb> boxes;
    std::uint64_t rejected = 0;
    std::vector<PartId> rejected_parts;  // of bodies with named parts: the part of each of them
    std::size_t place = 0;               // in the set
  };

  template <class Primitive>
  void countLeftOut(const Scene& scene, BodyId id, const WorkingSet& set, const CycleLimit& limit,
                    Counters& counters);
  template <class Primitive>
  void addBody(const Scene& scene, BodyId id, const PartnerBoxes<BoxOf<Primitive>>& partners,
               const CycleLimit& limit, WorkingSet& set, Counters& counters);
  void identifyVertices(const Body& body, bool self, bool moving, std::uint32_t first,
                        const CycleLimit& limit, WorkingSet& set);
  template <class Primitive>
  void addAllTriangles(const Body& body, BodyId id, const CycleLimit& limit, WorkingSet& set);
  template <class Primitive>
  void chooseTriangles(const Body& body, BodyId id, std::uint32_t first,
                       const PartnerBoxes<BoxOf<Primitive>>& partners, const CycleLimit& limit,
                       const WorkingSet& set);
  std::uint64_t addChosen(const Body& body, BodyId id, const CycleLimit& limit, WorkingSet& set);
  void listRejectedParts(const Body& body, BodyId id);

  BodyBoxes body_boxes_;
  VertexIdentity identity_;
  std::vector<std::uint32_t> least_equal_;
  std::vector<std::uint8_t> sides_;  // of a body's vertices
  std::vector<Block> blocks_;
  // Numbers of vertices and triangles in the set so far. The arrays are at least as long as in the
  // cycle before, so that they need not be cleared.
  std::size_t vertex_count_ = 0, triangle_count_ = 0;
  float growth_m_ = 0;                           // of the body at hand
  std::array<std::uint64_t, 256> of_part_ = {};  // its rejected triangles by part
  std::vector<RejectedPart> rejected_parts_;     // of the bodies before it
};

// Returns the motion that most vertices of a scene have in common during the time interval [m], as
// commonMotion() finds it in a sample of the vertices of all bodies that take part.
DCM_EXPORT Vec3f commonMotionOf(const Scene& scene);

}  // namespace deformable_contact_monitor
