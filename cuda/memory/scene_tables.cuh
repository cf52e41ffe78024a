// Builds tables on the host that describe a scene for the device.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <utility>
#include <vector>

#include "core/common/scene_queries.h"
#include "core/scene.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/pinned_memory.cuh"

namespace deformable_contact_monitor {

// Describes the bodies that are in some enabled pair: which pairs those are, and the consecutive
// numbers of their vertices, triangles and tiles. Lists that are sent to the device lie in
// pinnedMemory().
struct SceneTables {
  template <class T>
  using List = std::pmr::vector<T>;

  SceneTables() = default;
  // Throws CudaError if the scene is too large.
  explicit SceneTables(const Scene& scene);

  std::vector<BodyId> taking_part;           // the scene's id of each body on the device
  std::vector<DeviceBody> bodies;            // for each of them; poses and margins are not set
  List<ListedBody> listed{&pinnedMemory()};  // for each of them
  List<BodyIndex> partners{&pinnedMemory()};
  List<std::uint32_t> group_mask{&pinnedMemory()};
  List<std::uint32_t> pair_enabled{&pinnedMemory()};  // pair_row words for each part
  List<std::uint32_t> part{&pinnedMemory()};          // see SceneArrays; empty without parts
  std::vector<std::pair<BodyId, PartId>> parts;       // by number; empty without parts
  PartUse part_use{};
  List<BodyBlock> vertex_blocks{&pinnedMemory()}, triangle_blocks{&pinnedMemory()};
  std::uint32_t pair_row = 0, group_count = 0;
  std::uint32_t vertex_count = 0, triangle_count = 0, tile_count = 0;
  std::uint32_t self_vertices = 0;  // of the bodies that may have contacts with themselves
  bool any_self = false;            // some body may
  bool any_self_mesh = false;       // triangles of such a body may share vertices by their numbers

 private:
  void addPairs(const Scene& scene, const BodyGroups& groups, BodyIndex row);
  void addParts(const Scene& scene);
  void makeRoom(const Scene& scene);
  void addMesh(const TriangleMesh& mesh, BodyIndex body);
};

}  // namespace deformable_contact_monitor
