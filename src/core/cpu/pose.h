// From the scene to the triangles that can be in contact at all: poses, boxes, culling.
#pragma once

#include <cstdint>
#include <vector>

#include "core/cpu/vertex_identity.h"
#include "core/detector.h"
#include "core/predicates/aabb.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Triangles of one cycle, in ascending (body, triangle) order. Boxes are of the posed float32
// vertices, grown by the body's margin.
struct WorkingSet {
  std::vector<Vec3f> vertices;           // scene frame [m], of all bodies that take part
  std::vector<std::uint32_t> vertex_id;  // per vertex: equal iff of one body and equal as received
  std::vector<std::uint32_t> corners;    // three indices into `vertices` per triangle
  std::vector<std::uint32_t> body;       // per triangle
  std::vector<std::uint32_t> triangle;   // per triangle: its id in the body
  std::vector<Aabb> boxes;               // per triangle
  std::vector<std::uint32_t> first_vertex;  // per body: where its vertices begin in `vertices`

  std::size_t size() const { return triangle.size(); }
  Triangle posed(std::size_t t) const {
    return {{vertices[corners[3 * t]], vertices[corners[3 * t + 1]], vertices[corners[3 * t + 2]]}};
  }
};

// Finds the working set; keeps its buffers, and the boxes of bodies whose vertices did not change,
// from call to call.
class WorkingSetBuilder {
 public:
  // A body takes part if its box meets a partner's; a triangle, if its box meets the box of a
  // partner of its body. Fills counters.triangles, rejected, posed, culled.
  void build(const Scene& scene, WorkingSet& set, Counters& counters);

 private:
  struct LocalBox {
    std::uint64_t vertices_revision = 0;  // none has 0
    Aabb box;                             // of the finite vertices, body frame
    bool all_finite = true;
  };

  void updateLocalBoxes(const Scene& scene);
  void poseBody(const Body& body, std::uint32_t first, std::vector<Vec3f>& vertices) const;

  void identifyVertices(const Body& body, bool self, std::uint32_t first, WorkingSet& set);

  std::vector<LocalBox> local_boxes_;
  VertexIdentity identity_;
  std::vector<std::uint32_t> least_equal_;
};

}  // namespace deformable_contact_monitor
