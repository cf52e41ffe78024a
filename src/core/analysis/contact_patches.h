// Joins the contacts of two bodies to patches: connected areas in which the bodies touch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/detector.h"
#include "core/scene.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// A patch is a set of triangle pairs of two bodies that are connected. Two pairs are adjacent iff
// their triangles of body_a, or those of body_b, are the same or share a vertex. If body_a and
// body_b are the same body, any two of their triangles count. A patch has all pairs that are
// adjacent to each other directly or through others. Vertices are the same iff their coordinates as
// received are equal (-0 equals 0). Pairs that are only near count like those that touch. All
// values are in the scene frame.
struct Patch {
  BodyId body_a = 0, body_b = 0;  // body_a <= body_b
  std::uint32_t id = 0;           // see PatchTracker
  std::size_t pair_count = 0;
  std::vector<std::uint32_t> triangles_a, triangles_b;  // ascending, each once
  // Mean of the intersection segments' middles, weighted by length [m]. If no segment has a length,
  // mean of the middles between point_a and point_b of all pairs.
  Vec3d centroid;
  // Mean unit vector from a to b, over the pairs whose normal is defined. The normal of a coplanar
  // pair has an arbitrary sign, so it counts with the sign that is nearer to the others. Zero if no
  // normal is defined, or if they cancel out. For a body with itself, the triangles' indices decide
  // which is a, so normals point to either side, and the spread is large.
  Vec3d normal;
  double normal_spread_rad =
      0;  // mean angle between those normals and `normal`; NaN if that is zero
  // Length of the intersection curve [m]: the sum over pairs that intersect and are not coplanar.
  // If the curve runs along an edge, each pair of triangles at that edge counts.
  double curve_length_m = 0;
  double area_a_m2 = 0, area_b_m2 = 0;  // of the triangles listed
  double min_separation_m = 0;          // over the pairs where it is defined; NaN: over none
};

// Joins the contacts of a scene to patches. Keeps memory from call to call. One thread at a time.
class PatchFinder {
 public:
  // Returns the patches of a result of this scene, sorted by bodies, then by the first contact.
  // Each contact is in one patch. Ids are zero. Throws std::invalid_argument if contacts have no
  // geometry.
  std::vector<Patch> find(const Scene& scene, const DetectionResult& result);

 private:
  // Numbers of those vertices of a body that contacts use.
  struct VertexNumbers {
    std::vector<std::uint32_t> of_vertex;    // by vertex; kNone: no contact uses it
    std::vector<std::uint32_t> asked;        // the vertices that are not kNone
    std::vector<std::uint32_t> table;        // open addressing: a vertex of `asked`, or kNone
    std::vector<std::uint32_t> of_triangle;  // by triangle: number of a vertex of it, once joined
    std::vector<std::uint32_t> joined;       // the triangles that are not kNone
  };

  // Gives numbers to vertices during one call.
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
