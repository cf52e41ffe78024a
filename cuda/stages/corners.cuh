// A triangle's vertices as the stage pose left them.
#pragma once

#include "core/rules/common_motion.h"
#include "core/rules/half_space.h"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// A triangle as the stage pose left it: posed vertices [m] and their nearest prototypes. With
// kStates == 2 those at the beginning of the step come first.
template <int kStates>
struct Corners {
  static constexpr int kPoints = 3 * kStates, kPresent = kPoints - 3;
  Vec3f v[kPoints];
  NearestPrototype nearest[kPoints];

  __device__ Corners(const SceneArrays& scene, const VertexIndex vertices[3]) {
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
  // Of all that it passes, but for the common motion [m].
  __device__ Aabb box(const CycleArrays& c) const {
    if (kStates == 1) return boxOf(posed());
    return sweptBox(MovingBox{boxOf(earlier()), boxOf(posed())}, c.scene.common_motion[Place(0)]);
  }
  // Of all that it passes, for the shares; `grown`: by its body's margin or pad [m].
  __device__ bool reachesInto(const SceneShare& share, float grown_m) const {
    if (kStates == 1) return share.reaches(inflated(boxOf(posed()), grown_m));
    return share.reaches(shareBox({boxOf(earlier()), boxOf(posed())}, grown_m));
  }

 private:
  __device__ void set(int k, const float4& p) {
    const std::uint32_t w = __float_as_uint(p.w);
    v[k] = {p.x, p.y, p.z};
    nearest[k] = {w >> 1, (w & 1) != 0};
  }
};

// The vertices for the clusters [scaled].
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

}  // namespace deformable_contact_monitor
