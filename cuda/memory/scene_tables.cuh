// What the device gets of a scene's make-up, tabulated on the host.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <vector>

#include "core/common/body_groups.h"
#include "core/scene.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/pinned_memory.cuh"

namespace deformable_contact_monitor {

// Bodies of which some pair is enabled: which pairs those are, and their vertices, triangles and
// tiles numbered through, in the bodies' order. What is for the device lies in pinnedMemory().
struct SceneTables {
  template <class T>
  using List = std::pmr::vector<T>;

  SceneTables() = default;
  // Throws CudaError if the scene is too large.
  explicit SceneTables(const Scene& scene);

  std::vector<BodyId> taking_part;           // bodies of the scene, per body on the device
  std::vector<DeviceBody> bodies;            // the same; poses and margins are not filled in
  List<ListedBody> listed{&pinnedMemory()};  // the same
  List<BodyIndex> partners{&pinnedMemory()};
  List<std::uint32_t> group_mask{&pinnedMemory()};
  List<std::uint32_t> pair_enabled{&pinnedMemory()};  // pair_row words a body
  List<BodyBlock> vertex_blocks{&pinnedMemory()}, triangle_blocks{&pinnedMemory()};
  std::uint32_t pair_row = 0, group_count = 0;
  std::uint32_t vertex_count = 0, triangle_count = 0, tile_count = 0;
  bool any_self = false;

 private:
  void addPairs(const Scene& scene, const BodyGroups& groups, BodyIndex row);
  void makeRoom(const Scene& scene);
  void addMesh(const TriangleMesh& mesh, BodyIndex body);
};

}  // namespace deformable_contact_monitor
