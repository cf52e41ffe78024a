// Reads the results of stage transform for stage assign: a triangle's vertices with their nearest
// prototypes, and the boxes of bodies.
#pragma once

#include "core/rules/common_motion.h"
#include "core/rules/half_space.h"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Return a triangle in the scene frame [m]; in swept motion, its present state. `numbers`: one of
// SceneArrays::slot_numbers.
__device__ inline Triangle posedTriangle(const SceneArrays& scene, const uint4& numbers) {
  const VertexIndex corner[3] = {VertexIndex(numbers.x), VertexIndex(numbers.y),
                                 VertexIndex(numbers.z)};
  Triangle posed;
  for (int k = 0; k < 3; ++k) {
    const float4 v = scene.posed[corner[k]];
    posed.v[k] = {v.x, v.y, v.z};
  }
  return posed;
}
__device__ inline Triangle posedTriangle(const SceneArrays& scene, TriangleIndex triangle) {
  const VertexIndex* const corner = scene.corners.row(triangle);
  return posedTriangle(
      scene, make_uint4(corner[0].value, corner[1].value, corner[2].value, triangle.value));
}

// A triangle as stage transform leaves it: its vertices in the scene frame [m] and their nearest
// prototypes. With kStates == 2 (swept motion) the vertices at the beginning of the time interval
// come first.
template <int kStates>
struct Corners {
  static constexpr int kPoints = 3 * kStates, kPresent = kPoints - 3;
  Vec3f v[kPoints];
  NearestPrototype nearest[kPoints];

  // `numbers`: one of SceneArrays::slot_numbers.
  __device__ Corners(const SceneArrays& scene, const uint4& numbers) {
    const VertexIndex vertices[3] = {VertexIndex(numbers.x), VertexIndex(numbers.y),
                                     VertexIndex(numbers.z)};
    for (int k = 0; k < 3; ++k) {
      set(kPresent + k, scene.posed[vertices[k]]);
      if (kStates > 1) set(k, scene.earlier_posed[vertices[k]]);
    }
  }
  __device__ Triangle posed() const { return {{v[kPresent], v[kPresent + 1], v[kPresent + 2]}}; }
  __device__ Triangle earlier() const { return {{v[0], v[1], v[2]}}; }
  __device__ bool isFinite() const {
    bool finite = true;
    for (int k = 0; k < kPoints; ++k) {
      finite = finite && deformable_contact_monitor::isFinite(v[k]);
    }
    return finite;
  }
  // Returns the box of all places that the triangle passes, minus the common motion [m].
  __device__ Aabb box(const CycleArrays& c) const {
    if (kStates == 1) return boxOf(posed());
    return sweptBox(MovingBox{boxOf(earlier()), boxOf(posed())}, c.scene.common_motion[Place(0)]);
  }
  // Returns whether the box of all places that the triangle passes reaches into the partition.
  // `grown_m`: the margin or pad of its body [m].
  __device__ bool reachesInto(const ScenePartition& partition, float grown_m) const {
    if (kStates == 1) return partition.reaches(inflated(boxOf(posed()), grown_m));
    return partition.reaches(partitionBox({boxOf(earlier()), boxOf(posed())}, grown_m));
  }

 private:
  __device__ void set(int k, const float4& p) {
    const std::uint32_t w = __float_as_uint(p.w);
    v[k] = {p.x, p.y, p.z};
    nearest[k] = {w >> 1, (w & 1) != 0};
  }
};

// The vertices as the clusters use them [scaled]. In swept motion the common motion is subtracted
// from the present state.
template <int kStates>
struct ScaledCorners {
  Vec3f v[3 * kStates];

  __device__ ScaledCorners(const CycleArrays& c, const Corners<kStates>& corners) {
    const SceneScale scale = c.params().scale;
    for (int k = 0; k < 3; ++k) v[k] = scale.apply(corners.v[k]);
    if (kStates == 1) return;
    const SceneScale after = withoutMotion(scale, c.scene.common_motion[Place(0)]);
    for (int k = 3; k < 3 * kStates; ++k) v[k] = after.apply(corners.v[k]);
  }
};

// Returns the box of a body's finite vertices, inflated by its margin [m].
__device__ inline Aabb bodyBox(const SceneArrays& scene, BodyIndex body) {
  return inflated(boxOf(scene.body_boxes.row(body)), scene.bodies[body].margin_m);
}

// Returns whether no triangle of the body can be in contact with any other one.
__device__ inline bool isOutOfReach(const SceneArrays& scene, BodyIndex b) {
  const DeviceBody& body = scene.bodies[b];
  if (body.has_self != 0) return false;
  const Aabb own = bodyBox(scene, b);
  for (unsigned p = 0; p < body.partner_count; ++p) {
    const BodyIndex partner = scene.partners[Place(body.partner_begin + p)];
    if (intersects(own, bodyBox(scene, partner))) return false;
  }
  return true;
}

}  // namespace deformable_contact_monitor
