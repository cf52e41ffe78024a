// What the device gets of a scene's make-up, tabulated on the host.
#pragma once

#include <cstdint>
#include <vector>

#include "core/body_groups.h"
#include "core/scene.h"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Bodies of which some pair is enabled: which pairs those are, and their vertices, triangles and
// tiles numbered through, in the bodies' order.
struct SceneTables {
  SceneTables() = default;
  // Throws CudaError if the scene is too large.
  explicit SceneTables(const Scene& scene);

  // The corners of the triangles of all bodies from that one on.
  void putCorners(const Scene& scene, std::uint32_t first_body, VertexIndex* corners) const;

  std::vector<BodyId> taking_part;  // bodies of the scene, per body on the device
  std::vector<DeviceBody> bodies;   // the same; poses and margins are not filled in
  std::vector<ListedBody> listed;   // the same
  std::vector<BodyIndex> partners;
  std::vector<std::uint32_t> group_mask, pair_enabled;  // pair_row words of the latter a body
  std::vector<BodyBlock> vertex_blocks, triangle_blocks;
  std::uint32_t pair_row = 0, group_count = 0;
  std::uint32_t vertex_count = 0, triangle_count = 0, tile_count = 0;
  bool any_self = false;

 private:
  void addPairs(const Scene& scene, const BodyGroups& groups, BodyIndex row);
  void requireRoom(const Scene& scene) const;
  void addMesh(const TriangleMesh& mesh, BodyIndex body);
};

}  // namespace deformable_contact_monitor
