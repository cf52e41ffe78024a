// Bodies in the scene frame: vertices and triangles of one body, and boxes that hold them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/predicates/aabb.h"
#include "core/predicates/triangle.h"
#include "core/rigid_transform.h"
#include "core/rules/posed_vertex.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// A view of a body whose pose is applied to each vertex when it is read. The body's mesh must be
// valid, and must outlive the view. Any number of threads may read.
class PosedBody {
 public:
  explicit PosedBody(const Body& body) : PosedBody(body, body.pose) {}
  // Takes another pose, which must outlive the view too.
  PosedBody(const Body& body, const RigidTransform& pose)
      : PosedBody(pose, body.mesh.vertices.data(), body.mesh.triangles.data()) {}

  // Returns the body as it was at the beginning of the time interval. A body without an earlier
  // state stands still.
  static PosedBody earlier(const Body& body) {
    if (!body.earlier) return PosedBody(body);
    const EarlierState& state = *body.earlier;
    const float* const xyz =
        state.vertices.empty() ? body.mesh.vertices.data() : state.vertices.data();
    return {state.pose, xyz, body.mesh.triangles.data()};
  }

  // Returns vertex i in the scene frame [m]. Every backend rounds it in the same way, so it may be
  // infinite where the received vertex is finite.
  Vec3f vertex(std::size_t i) const { return posedVertex(*pose_, identity_, receivedVertex(i)); }

  // Returns triangle t in the scene frame [m].
  Triangle triangle(std::uint32_t t) const {
    const std::uint32_t* corner = corners(t);
    return {{vertex(corner[0]), vertex(corner[1]), vertex(corner[2])}};
  }

  // Hide the memory's latency where triangles are read in random order. Call the first about 32
  // triangles ahead of triangle(t), and the second about 16 ahead.
  void prefetchCorners(std::uint32_t t) const { __builtin_prefetch(corners(t)); }
  void prefetchVertices(std::uint32_t t) const {
    const std::uint32_t* corner = corners(t);
    for (int k = 0; k < 3; ++k) __builtin_prefetch(xyz_ + 3 * std::size_t{corner[k]});
  }

  // Returns triangle t as it was received, in the body's frame [m].
  Triangle received(std::uint32_t t) const {
    const std::uint32_t* corner = corners(t);
    return {{receivedVertex(corner[0]), receivedVertex(corner[1]), receivedVertex(corner[2])}};
  }

 private:
  PosedBody(const RigidTransform& pose, const float* xyz, const std::uint32_t* triangles)
      : pose_(&pose), identity_(pose.isIdentity()), xyz_(xyz), triangles_(triangles) {}

  Vec3f receivedVertex(std::size_t i) const {
    const float* v = xyz_ + 3 * i;
    return {v[0], v[1], v[2]};
  }
  const std::uint32_t* corners(std::uint32_t t) const { return triangles_ + 3 * std::size_t{t}; }

  const RigidTransform* pose_;
  bool identity_;
  const float* xyz_;
  const std::uint32_t* triangles_;
};

// Returns a box in the scene frame [m] that holds the posed float32 place of every vertex in the
// box `received`, which is in the body's frame. The result is finite only if all of these places
// certainly are, and empty if `received` is.
inline Aabb posedBox(const Aabb& received, const RigidTransform& pose, bool is_identity) {
  if (received.empty() || is_identity) return received;
  const double lo[3] = {received.min.x, received.min.y, received.min.z};
  const double hi[3] = {received.max.x, received.max.y, received.max.z};
  float min[3], max[3];
  for (int i = 0; i < 3; ++i) {
    double centre = pose.translation[i], extent = 0, size = std::fabs(pose.translation[i]);
    for (int j = 0; j < 3; ++j) {
      const double r = pose.rotation[3 * i + j];
      centre += r * (lo[j] + hi[j]) / 2;
      extent += std::fabs(r) * (hi[j] - lo[j]) / 2;
      size += std::fabs(r) * std::max(std::fabs(lo[j]), std::fabs(hi[j]));
    }
    // Covers the float32 rounding of the vertices (2^-24 of their size) and of the box itself.
    const double reach = extent + size * 2.5e-7 + 1e-44;
    // Where a double overflows, nothing is certain, and the box is infinite along this axis.
    const bool is_known = std::isfinite(centre) && std::isfinite(reach);
    min[i] = is_known ? toFloat(centre - reach) : -INFINITY;
    max[i] = is_known ? toFloat(centre + reach) : INFINITY;
  }
  return {{min[0], min[1], min[2]}, {max[0], max[1], max[2]}};
}

}  // namespace deformable_contact_monitor
