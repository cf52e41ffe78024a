// Contacts of two bodies joined to patches: what touches in one place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/detector.h"
#include "core/scene.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Triangle pairs of two bodies that hang together, in the scene frame. Two pairs do iff their
// triangles of body_a, or those of body_b, are the same or share a vertex, or pairs between do; of
// a body with itself, iff any of their triangles are or do. Vertices are one iff their coordinates
// as received are equal (-0 equals 0). Pairs that are only near count like those that touch.
struct Patch {
  BodyId body_a = 0, body_b = 0;  // body_a <= body_b
  std::uint32_t id = 0;           // see PatchTracker
  std::size_t pair_count = 0;
  std::vector<std::uint32_t> triangles_a, triangles_b;  // ascending, each once
  // Mean of the intersection segments' middles by length; where there is no segment with a length,
  // of the middles between point_a and point_b of all pairs [m].
  Vec3d centroid;
  // Mean unit vector from a to b of the pairs whose normal is defined. Coplanar pairs, whose normal
  // has either sign, count with the sign that is nearer to the others'. Zero where there is none or
  // they cancel out. Of a body with itself, the triangles' numbers say which is a and which is b,
  // so normals have either side, and the spread says so.
  Vec3d normal;
  double normal_spread_rad = 0;  // mean angle of those normals to it; NaN where it is zero
  // Sum over the pairs that touch and are not coplanar: where the curve runs along an edge, each
  // pair counts [m].
  double curve_length_m = 0;
  double area_a_m2 = 0, area_b_m2 = 0;  // of the triangles listed
  double min_separation_m = 0;          // of the pairs where it is defined; NaN: of none
};

// Joins the contacts of a scene to patches. Keeps memory from call to call. One thread at a time.
class PatchFinder {
 public:
  // `result`: of the scene, with its geometry. By bodies, then by the first contact; each contact
  // is in one patch; ids are zero. Throws std::invalid_argument where contacts have no geometry.
  std::vector<Patch> find(const Scene& scene, const DetectionResult& result);

 private:
  // The vertices of a body that contacts have, as numbers.
  struct VertexNumbers {
    std::vector<std::uint32_t> of_vertex;    // by vertex; kNone where not asked for
    std::vector<std::uint32_t> asked;        // those that are not kNone
    std::vector<std::uint32_t> table;        // open addressing: an asked vertex, or kNone
    std::vector<std::uint32_t> of_triangle;  // by triangle: of a vertex of it, once that is joined
    std::vector<std::uint32_t> joined;       // those that are not kNone
  };

  class Numbering;

  std::vector<std::vector<std::uint32_t>> joinedContacts(
      const Scene& scene, const TrianglePairs& pairs, const std::vector<std::uint32_t>& contacts);
  std::vector<std::uint32_t> trianglesOf(const TrianglePairs& pairs,
                                         const std::vector<std::uint32_t>& contacts,
                                         std::uint32_t TrianglePair::*triangle);

  VertexNumbers numbers_[2];
  std::vector<bool> seen_;  // by triangle; all false between uses
};

}  // namespace deformable_contact_monitor
