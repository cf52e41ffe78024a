// What a detector looks at: bodies, their poses, and which pairs of bodies matter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/export.h"
#include "core/rigid_transform.h"
#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

using BodyId = std::uint32_t;

// Vertices in the memory of a CUDA device: see Scene::setDeviceVertices().
struct DCM_EXPORT DeviceVertices {
  const float* xyz;  // as many as the mesh has, x y z each [m]
  void* stream;      // a cudaStream_t; null: the legacy default stream
};

// Where a body was at the beginning of a step. Each vertex, in the scene frame and rounded to
// float32 there, moves from its place then to its present one on a straight line.
struct DCM_EXPORT EarlierState {
  RigidTransform pose;
  // In the body's frame then, as many as the mesh has [m]. Empty: the present ones.
  HostList<float> vertices;
};

struct DCM_EXPORT Body {
  std::string name;
  TriangleMesh mesh;  // in the body's frame
  // In place of mesh.vertices, which then only say how many there are.
  std::optional<DeviceVertices> device_vertices;
  RigidTransform pose;  // scene frame from body frame; identity leaves the vertices untouched
  float margin_m = 0;   // a pair of bodies counts at a distance <= the larger of its two margins
  // What follows is for swept motion alone. No earlier state: the body stands still in this step.
  std::optional<EarlierState> earlier;
  // Its points' true ways are at most this far from the straight ones. Those of two bodies add up.
  float pad_m = 0;
  // Revisions say what changed since a detector last looked; they only grow, and equal ones, of
  // whatever scene, mean equal data.
  std::uint64_t topology_revision = 0;
  std::uint64_t vertices_revision = 0;
  std::uint64_t earlier_revision = 0;  // of earlier->vertices
};

// Plain data, for one thread at a time. Pairs of bodies, and a body with itself, are off until
// they are switched on. Every refusal is a std::invalid_argument that names the body and leaves the
// scene as it was.
class DCM_EXPORT Scene {
 public:
  // From now on meshes lie in `memory`, which outlives this: a detector's vertexMemory(), which
  // spares it a copy. Copies of the scene are in plain memory.
  void useMemory(std::pmr::memory_resource& memory);

  // Adds a body (its mesh may be empty, to be set later); ids count up from 0.
  BodyId addBody(std::string name, TriangleMesh mesh);

  // Replaces vertices and triangles. The body has no earlier state then.
  void setMesh(BodyId id, TriangleMesh mesh);

  // Replaces the vertices: `count` of them, x y z each [m]; must be as many as before. A copy: the
  // caller's may go.
  void setVertices(BodyId id, const float* xyz, std::size_t count);

  // As setVertices(), but they are in the memory of a CUDA device (or managed memory), and stay
  // there: no copy is made before a detector reads them. It reads behind what is in `stream` by
  // then, so that kernels which still write the vertices are waited for, whatever the limits.
  // Whoever writes there again, once detect() has returned, calls this again ahead of the next
  // detect(); memory and stream must live until the body has other vertices or is looked at no
  // more. The CUDA backend alone reads them, on its own device; detect() of any other throws
  // std::invalid_argument, naming the body, if the body takes part. Refuses null, but for a body
  // without vertices.
  void setDeviceVertices(BodyId id, const float* device_xyz, std::size_t count,
                         void* stream = nullptr);

  // Refuses a pose with a non-finite number.
  void setPose(BodyId id, const RigidTransform& pose);

  // [m], finite and >= 0.
  void setMargin(BodyId id, float margin_m);

  // Body::earlier. Refuses a pose with a non-finite number, and another number of vertices than the
  // mesh has (but for none: the present ones).
  void setEarlier(BodyId id, const RigidTransform& pose, HostList<float> vertices = {});
  void clearEarlier(BodyId id);

  // Body::pad_m: [m], finite and >= 0.
  void setPad(BodyId id, float pad_m);

  // a == b: contacts of the body with itself.
  void setPairEnabled(BodyId a, BodyId b, bool enabled);
  bool pairEnabled(BodyId a, BodyId b) const;
  // All of them, (a, b) with a <= b, ascending.
  std::vector<std::pair<BodyId, BodyId>> enabledPairs() const;
  // Whether some pair of the body, or the body with itself, is enabled.
  bool takesPart(BodyId id) const;
  // Whether some body that takes part has a margin.
  bool anyMargin() const;
  // Whether some body that takes part has a pad.
  bool anyPad() const;
  // Like the bodies' revisions: of the enabled pairs and the number of bodies.
  std::uint64_t pairsRevision() const { return pairs_revision_; }

  std::size_t bodyCount() const { return bodies_.size(); }
  std::size_t triangleCount() const;
  const Body& body(BodyId id) const { return bodies_.at(id); }
  const std::vector<Body>& bodies() const { return bodies_; }

 private:
  static void requireFinite(const Body& body, const RigidTransform& pose);
  bool anyBody(float Body::*length_m) const;
  Body& checkedBody(BodyId id);
  Body& checkedBody(BodyId id, std::size_t vertex_count);

  std::vector<Body> bodies_;
  std::vector<std::vector<bool>> enabled_;  // symmetric
  std::uint64_t pairs_revision_ = 0;
  std::pmr::memory_resource* memory_ = std::pmr::new_delete_resource();
};

}  // namespace deformable_contact_monitor
