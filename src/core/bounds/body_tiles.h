// Makes the boxes of a body's regions and tiles in the scene of one cycle. All boxes come from one
// pass over the vertices. Tiles with posed vertices are made on demand.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/bounds/posed_tile.h"
#include "core/common/cycle_limit.h"
#include "core/predicates/aabb.h"
#include "core/scene.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// Keeps what does not change from cycle to cycle. All boxes are in the scene frame [m] and hold the
// posed float32 vertices of all triangles that are not rejected. They end at the largest float32,
// and are empty if there is no such triangle.
//
// Without a tiling, a tile is a run of 32 triangles in the order of the mesh, and a region a run of
// 32 tiles. That costs nothing when the topology changes, and suits meshes whose order follows
// their surface.
class BodyTiles {
 public:
  // Begins a cycle, on the threads of this TBB arena. `tiling` may be null. Returns false if the
  // limit was over; then the object is of no use in this cycle. The body must live, unchanged,
  // until the cycle ends, and its vertices must be on the host.
  bool update(const Body& body, std::shared_ptr<const Tiling> tiling, const CycleLimit& limit);

  // Any number of threads may call the following functions.
  const Aabb& box() const { return box_; }
  const std::vector<Aabb>& regions() const { return region_boxes_; }
  // The tiles of a region are numbered from tileBegin() up to, but not including, tileEnd().
  std::size_t tileBegin(std::size_t region) const {
    return tiling_ ? tiling_->region_begin[region] : region * Tiling::kRegionTiles;
  }
  std::size_t tileEnd(std::size_t region) const {
    return tiling_ ? tiling_->region_begin[region + 1] : least(tileBegin(region + 1), tileCount());
  }
  Aabb tileBox(std::size_t tile) const { return posed(received_tiles_[tile]); }

  // Return the least index of a triangle in a tile or a region; it may be of a rejected one.
  std::uint32_t firstOfTile(std::size_t tile) const {
    return tiling_ ? first_of_tile_[tile]
                   : static_cast<std::uint32_t>(tile * Tiling::kTileTriangles);
  }
  std::uint32_t firstOfRegion(std::size_t region) const {
    return tiling_ ? first_of_region_[region] : firstOfTile(tileBegin(region));
  }

  // Return the part of all triangles of a tile or a region; kSeveralParts if they are of several.
  std::uint32_t partOfTile(std::size_t tile) const {
    return part_of_tile_.empty() ? 0 : part_of_tile_[tile];
  }
  std::uint32_t partOfRegion(std::size_t region) const {
    return part_of_region_.empty() ? 0 : part_of_region_[region];
  }
  static constexpr std::uint32_t kSeveralParts = 256;

  // Returns a tile with posed vertices. It is made by the first call in a cycle.
  const PosedTile& tile(std::size_t tile) const;

  Triangle posedTriangle(std::uint32_t t) const { return PosedBody(*body_).triangle(t); }

  // Returns true only if certainly no triangle was rejected.
  bool allFinite() const { return all_finite_; }

 private:
  // A tile, the number of the cycle in which it was made, and a spin lock to make it.
  struct Slot {
    std::unique_ptr<PosedTile> tile;
    std::atomic<std::uint64_t> made{0};
    std::atomic_flag busy = ATOMIC_FLAG_INIT;
  };

  std::size_t tileCount() const { return received_tiles_.size(); }
  void begin(std::shared_ptr<const Tiling> tiling);
  void findParts();
  bool receive(const CycleLimit& limit);
  void receiveRegion(std::size_t region);
  void receiveTile(std::size_t tile, bool& all_finite);
  Aabb posed(const Aabb& received) const;

  const Body* body_ = nullptr;
  std::shared_ptr<const Tiling> tiling_;  // null: tiles are runs of triangles
  std::uint64_t topology_revision_ = 0;  // of the body for which the lists below have their lengths
  std::vector<std::uint32_t> first_of_tile_, first_of_region_;  // empty without a tiling
  std::uint64_t parts_revision_ = 0;  // of the body for which the next two lists are
  std::vector<std::uint16_t> part_of_tile_, part_of_region_;  // empty without named parts
  std::uint64_t vertices_revision_ = 0;                  // of the received boxes; 0: there are none
  std::vector<Aabb> received_tiles_, received_regions_;  // body frame [m]
  std::vector<std::uint8_t> finite_regions_;
  bool received_finite_ = true;

  bool is_identity_ = true;
  Aabb box_;
  std::vector<Aabb> region_boxes_;
  bool all_finite_ = true;
  std::uint64_t cycle_ = 0;
  mutable std::unique_ptr<Slot[]> slots_;
  std::size_t slot_count_ = 0;
};

}  // namespace deformable_contact_monitor
