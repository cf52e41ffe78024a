// Which bodies can touch which, by their boxes; once the stage pose is over.
#pragma once

#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Of a body's finite vertices, with its margin [m].
__device__ inline Aabb bodyBox(const SceneArrays& scene, BodyIndex body) {
  return inflated(boxOf(scene.body_boxes.row(body)), scene.bodies[body].margin_m);
}

// Whether no triangle of the body can be in contact with any other one.
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
