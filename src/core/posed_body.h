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
  explicit PosedBody(const Body& body) : body_(&body), identity_(body.pose.isIdentity()) {}

  // [m]; rounded as every backend does, so it may be infinite where the received one is not.
  Vec3f vertex(std::size_t i) const {
    return posedVertex(body_->pose, identity_, body_->mesh.vertex(i));
  }

  // [m].
  Triangle triangle(std::uint32_t t) const {
    const std::uint32_t* corner = corners(t);
    return {{vertex(corner[0]), vertex(corner[1]), vertex(corner[2])}};
  }

  // In the body's frame [m].
  Triangle received(std::uint32_t t) const {
    const std::uint32_t* corner = corners(t);
    const TriangleMesh& mesh = body_->mesh;
    return {{mesh.vertex(corner[0]), mesh.vertex(corner[1]), mesh.vertex(corner[2])}};
  }

 private:
  const std::uint32_t* corners(std::uint32_t t) const {
    return &body_->mesh.triangles[3 * std::size_t{t}];
  }

  const Body* body_;
  bool identity_;
};

}  // namespace deformable_contact_monitor
