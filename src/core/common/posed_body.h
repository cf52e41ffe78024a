// A body's vertices and triangles in the scene frame.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/predicates/triangle.h"
#include "core/rules/posed_vertex.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// A view: the body's mesh must be valid, and outlive it. Any number of threads may read.
class PosedBody {
 public:
  explicit PosedBody(const Body& body)
      : PosedBody(body.pose, body.mesh.vertices.data(), body.mesh.triangles.data()) {}

  // Where it was at the beginning of the step; without an earlier state it stands still.
  static PosedBody earlier(const Body& body) {
    if (!body.earlier) return PosedBody(body);
    const EarlierState& state = *body.earlier;
    const float* const xyz =
        state.vertices.empty() ? body.mesh.vertices.data() : state.vertices.data();
    return {state.pose, xyz, body.mesh.triangles.data()};
  }

  // [m]; rounded as every backend does, so it may be infinite where the received one is not.
  Vec3f vertex(std::size_t i) const { return posedVertex(*pose_, identity_, receivedVertex(i)); }

  // [m].
  Triangle triangle(std::uint32_t t) const {
    const std::uint32_t* corner = corners(t);
    return {{vertex(corner[0]), vertex(corner[1]), vertex(corner[2])}};
  }

  // Ahead of triangle(t), where they come in no order: the first some 32 of them ahead, the second
  // some 16.
  void prefetchCorners(std::uint32_t t) const { __builtin_prefetch(corners(t)); }
  void prefetchVertices(std::uint32_t t) const {
    const std::uint32_t* corner = corners(t);
    for (int k = 0; k < 3; ++k) __builtin_prefetch(xyz_ + 3 * std::size_t{corner[k]});
  }

  // In the body's frame [m].
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

}  // namespace deformable_contact_monitor
