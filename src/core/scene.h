// The input of a detector: bodies, their poses, and which pairs of bodies to check.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
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

// The number of a part of a body. 0 is the body's own rest: the triangles of no named part.
using PartId = std::uint8_t;

// Two parts, with (body_a, part_a) <= (body_b, part_b) lexicographically.
struct DCM_EXPORT PartPair {
  BodyId body_a, body_b;
  PartId part_a, part_b;

  bool operator==(const PartPair& o) const {
    return body_a == o.body_a && part_a == o.part_a && body_b == o.body_b && part_b == o.part_b;
  }
  bool operator<(const PartPair& o) const {
    if (body_a != o.body_a) return body_a < o.body_a;
    if (part_a != o.part_a) return part_a < o.part_a;
    if (body_b != o.body_b) return body_b < o.body_b;
    return part_b < o.part_b;
  }
};

// Vertices in the memory of a CUDA device (see Scene::setDeviceVertices()).
struct DCM_EXPORT DeviceVertices {
  const float* xyz;  // as many vertices as the mesh has, x y z each [m]
  void* stream;      // a cudaStream_t; null: the legacy default stream
};

// The state of a body at the beginning of the time interval of swept motion. Each vertex moves on a
// straight line in the scene frame, from its place then to its present one, both rounded to
// float32.
struct DCM_EXPORT EarlierState {
  RigidTransform pose;
  // Vertices in the body's frame, as many as the mesh has [m]. Empty: the present vertices.
  HostList<float> vertices;
};

struct DCM_EXPORT Body {
  std::string name;
  TriangleMesh mesh;  // in the body's frame
  // Replaces mesh.vertices, which then only tell how many vertices there are.
  std::optional<DeviceVertices> device_vertices;
  RigidTransform pose;  // scene frame from body frame; identity leaves the vertices untouched
  // Two bodies count at a distance of at most the larger of their margins [m]. If parts have
  // margins of their own, this is the largest margin of the body's triangles, see marginOf().
  float margin_m = 0;
  // The body is the set of all points at most this far from its triangles [m], so that a polyline
  // is a rope, and single points are grains (core/bounds/radii.h).
  float radius_m = 0;
  // The next two are for swept motion only. A body without an earlier state stands still.
  std::optional<EarlierState> earlier;
  // How far the true path of a point may be from its straight line [m]. The pads of two bodies add
  // up.
  float pad_m = 0;
  // Revisions tell a detector what changed since its last cycle. They only grow. Equal revisions
  // mean equal data, even in different scenes.
  std::uint64_t topology_revision = 0;
  std::uint64_t vertices_revision = 0;
  std::uint64_t earlier_revision = 0;  // of earlier->vertices
  std::uint64_t parts_revision = 0;    // of `parts`
  // The part of each triangle. Empty: the body has no named parts, and all of it is part 0.
  std::vector<PartId> parts;
  std::vector<PartId> listed_parts{0};  // those that triangles have, ascending
  // The margin of triangles whose part has none of its own, and the margins of parts [m].
  float own_margin_m = 0;
  std::map<PartId, float> part_margins_m;

  // Returns the margin of the triangles of a part [m].
  float marginOf(PartId part) const {
    const auto found = part_margins_m.find(part);
    return found == part_margins_m.end() ? own_margin_m : found->second;
  }
  PartId partOf(std::uint32_t triangle) const {
    return parts.empty() ? PartId{0} : parts[triangle];
  }
};

// Bodies and enabled pairs of bodies, for one thread at a time. Pairs of bodies, and a body with
// itself, are disabled until they are enabled. Functions that change the scene throw
// std::invalid_argument, naming the body, for bad values, and leave the scene as it was. Those that
// read it throw std::out_of_range for a body that does not exist.
class DCM_EXPORT Scene {
 public:
  // Stores meshes in `memory` from now on, which must outlive the scene. With a detector's
  // vertexMemory(), that detector needs one copy less. Copies of the scene use plain memory.
  void useMemory(std::pmr::memory_resource& memory);

  // Adds a body. Its mesh may be empty and be set later. Returns its id; ids count up from 0.
  BodyId addBody(std::string name, TriangleMesh mesh);

  // Replaces vertices and triangles. The body has no earlier state and no parts then.
  void setMesh(BodyId id, TriangleMesh mesh);

  // Replaces the vertices by a copy of `count` vertices, x y z each [m]. The number must be the
  // same as before.
  void setVertices(BodyId id, const float* xyz, std::size_t count);

  // Does what setVertices() does with vertices in the memory of a CUDA device, or managed memory.
  // They stay there: no copy is made before a detector reads them. The detector waits for all work
  // that is in `stream` at that time, such as kernels that still write the vertices, whatever the
  // limits are. After detect() has returned, the memory may be written again; call this function
  // again before the next detect(). Memory and stream must live until the body gets other vertices,
  // or until no detector reads it any more. Only the CUDA backend reads them, on its own device.
  // detect() of other backends throws std::invalid_argument, naming the body, if the body takes
  // part. Throws for a null pointer, unless the body has no vertices.
  void setDeviceVertices(BodyId id, const float* device_xyz, std::size_t count,
                         void* stream = nullptr);

  // Sets the pose. Throws for non-finite numbers.
  void setPose(BodyId id, const RigidTransform& pose);

  // Sets the margin [m], finite and >= 0, of all parts that have none of their own.
  void setMargin(BodyId id, float margin_m);

  // Sets margins of parts [m], finite and >= 0, in place of all earlier ones. Two triangles then
  // count at a distance of at most the larger of their parts' margins, in lists of near pairs and
  // for the nearest pairs of bodies and of parts. The setting stays when meshes and parts change.
  // Options.tolerance_m does not go with it: detect() throws std::invalid_argument, naming the
  // body, where a part's margin differs from the body's.
  void setPartMargins(BodyId id, std::map<PartId, float> margins_m);

  // Sets Body::radius_m [m], finite and >= 0. Motion::kSwept and options.tolerance_m do not go with
  // a radius: detect() throws std::invalid_argument then, naming the body.
  void setRadius(BodyId id, float radius_m);

  // Sets Body::earlier. Throws for non-finite numbers in the pose, and for another number of
  // vertices than the mesh has. No vertices at all mean the present ones.
  void setEarlier(BodyId id, const RigidTransform& pose, HostList<float> vertices = {});
  void clearEarlier(BodyId id);

  // Sets Body::pad_m [m], finite and >= 0.
  void setPad(BodyId id, float pad_m);

  // Divides a body into up to 255 named parts, 1 to 255, and its own rest, 0: `part_of_triangle`
  // has the part of each triangle of its mesh. An empty list removes the parts. Throws for any
  // other number of triangles.
  void setParts(BodyId id, std::vector<PartId> part_of_triangle);

  // Enables or disables a pair of parts, of two bodies or of one. All pairs of parts are enabled at
  // first. Two triangles are compared iff the pair of their bodies and the pair of their parts are
  // both enabled. The setting stays when meshes and parts change. Part 0 of a body without parts is
  // all of it.
  void setPartPairEnabled(BodyId a, PartId part_a, BodyId b, PartId part_b, bool enabled);
  // Enables all pairs of parts.
  void enableAllParts();
  // Returns whether the pair of these bodies and the pair of these parts are both enabled.
  bool partPairEnabled(BodyId a, PartId part_a, BodyId b, PartId part_b) const;
  // Returns the pairs of parts that are disabled, ascending.
  const std::vector<PartPair>& disabledParts() const { return disabled_parts_; }
  // Returns whether some pair of parts that have triangles is disabled while the pair of their
  // bodies is enabled. Otherwise parts change no contact and no distance.
  bool partsMatter() const;

  // Enables or disables a pair. With a == b: contacts of the body with itself.
  void setPairEnabled(BodyId a, BodyId b, bool enabled);
  bool pairEnabled(BodyId a, BodyId b) const;
  // Returns all enabled pairs (a, b) with a <= b, ascending.
  std::vector<std::pair<BodyId, BodyId>> enabledPairs() const;
  // Returns whether some pair of the body, or the body with itself, is enabled.
  bool takesPart(BodyId id) const;
  // Returns whether some body that takes part has a margin.
  bool anyMargin() const;
  // Returns whether some body that takes part has parts with other margins than its own.
  bool anyPartMargin() const;
  // Returns whether some body that takes part has a radius.
  bool anyRadius() const;
  // Returns whether some body that takes part has a pad.
  bool anyPad() const;
  // Returns a revision, like those of Body, of the enabled pairs of bodies and of parts, and of the
  // number of bodies.
  std::uint64_t pairsRevision() const { return pairs_revision_; }

  std::size_t bodyCount() const { return bodies_.size(); }
  std::size_t triangleCount() const;
  const Body& body(BodyId id) const { return bodies_.at(id); }
  const std::vector<Body>& bodies() const { return bodies_; }

 private:
  // Where meshes are stored: plain memory at first, and in copies of a scene.
  struct MeshMemory {
    MeshMemory() = default;
    MeshMemory(const MeshMemory& /*other*/) {}
    MeshMemory(MeshMemory&&) = default;
    // A scene that is assigned to keeps its own memory.
    // NOLINTNEXTLINE(bugprone-unhandled-self-assignment): nothing is assigned
    MeshMemory& operator=(const MeshMemory& /*other*/) { return *this; }
    MeshMemory& operator=(MeshMemory&&) = default;

    std::pmr::memory_resource* resource = std::pmr::new_delete_resource();
  };

  static void requireFinite(const Body& body, const RigidTransform& pose);
  bool anyBody(float Body::*length_m) const;
  static void sumUpMargins(Body* body);
  Body& checkedBody(BodyId id);
  Body& checkedBody(BodyId id, std::size_t vertex_count, const float* vertices);

  std::vector<Body> bodies_;
  std::vector<std::vector<bool>> enabled_;  // symmetric
  std::vector<PartPair> disabled_parts_;    // ascending
  std::uint64_t pairs_revision_ = 0;
  MeshMemory memory_;
};

}  // namespace deformable_contact_monitor
