// Bounds the regions and tiles of a body. The boxes in the body's own frame are kept until its
// vertices change. The boxes in the scene frame follow from these by the pose, which takes much
// less time than reading all vertices again. Vertices are posed only for the tiles that a search
// opens.
#include "core/bounds/body_tiles.h"

#include <algorithm>
#include <cfloat>
#include <cstring>
#include <utility>

#include "core/common/lanes.h"
#include "core/common/parallel.h"
#include "core/common/posed_body.h"

namespace deformable_contact_monitor {
namespace {

// Returns the box of those of `count` vertices that are finite. `vertex` are their indices, and
// `xyz` has the coordinates of all `vertex_count` vertices of the mesh. Sets all_finite to false if
// one of them is not finite. It reads a vertex into four lanes at once; the fourth lane is never
// used.
Aabb receivedBox(const float* xyz, std::size_t vertex_count, const std::uint32_t* vertex,
                 std::size_t count, bool& all_finite) {
  FloatLanes low = FloatLanes{} + INFINITY, high = FloatLanes{} - INFINITY, check{};
  for (std::size_t i = 0; i < count; ++i) {
    const float* const from = xyz + 3 * std::size_t{vertex[i]};
    FloatLanes v;
    if (vertex[i] + std::size_t{1} < vertex_count) {
      std::memcpy(&v, from, sizeof v);  // the fourth lane is the next vertex's x
    } else {
      v = FloatLanes{from[0], from[1], from[2], 0};
    }
    low = v < low ? v : low;
    high = v > high ? v : high;
    // This stays 0 for finite numbers, and becomes NaN for infinity and NaN.
    check += v - v;
  }
  if (check[0] + check[1] + check[2] == 0) {
    return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
  }
  all_finite = false;
  Aabb box;
  for (std::size_t i = 0; i < count; ++i) {
    const float* const from = xyz + 3 * std::size_t{vertex[i]};
    const Vec3f v{from[0], from[1], from[2]};
    if (isFinite(v)) box.include(v);
  }
  return box;
}

// Move the ends of a box into the range of finite float32 numbers.
float atLeastFinite(float low) { return low >= -FLT_MAX ? least(low, FLT_MAX) : -FLT_MAX; }
float atMostFinite(float high) { return high <= FLT_MAX ? most(high, -FLT_MAX) : FLT_MAX; }

// Returns whether a box ends before the largest float32, so that its pose cannot have made any
// vertex infinite.
bool isWithinFloats(const Aabb& box) {
  return least(least(box.min.x, box.min.y), box.min.z) > -FLT_MAX &&
         most(most(box.max.x, box.max.y), box.max.z) < FLT_MAX;
}

}  // namespace

bool BodyTiles::update(const Body& body, std::shared_ptr<const Tiling> tiling,
                       const CycleLimit& limit) {
  body_ = &body;
  ++cycle_;
  // What throws is done again next time, so revisions are noted afterwards.
  if (tiling_ != tiling || topology_revision_ != body.topology_revision) {
    topology_revision_ = parts_revision_ = 0;
    begin(std::move(tiling));
    findParts();
    topology_revision_ = body.topology_revision;
    parts_revision_ = body.parts_revision;
  }
  if (parts_revision_ != body.parts_revision) {
    parts_revision_ = 0;
    findParts();
    parts_revision_ = body.parts_revision;
  }
  if (vertices_revision_ != body.vertices_revision && !receive(limit)) return false;
  is_identity_ = body.pose.isIdentity();
  box_ = Aabb();
  region_boxes_.resize(received_regions_.size());
  for (std::size_t r = 0; r < region_boxes_.size(); ++r) {
    region_boxes_[r] = posed(received_regions_[r]);
    if (!region_boxes_[r].empty()) box_.include(region_boxes_[r]);
  }
  all_finite_ = received_finite_ && (box_.empty() || isWithinFloats(box_));
  return true;
}

// Begins with other tiles. Slots of tiles are kept, because making tiles anew takes memory.
void BodyTiles::begin(std::shared_ptr<const Tiling> tiling) {
  tiling_ = std::move(tiling);
  vertices_revision_ = 0;
  const std::size_t tiles = tiling_
                                ? tiling_->tileCount()
                                : blockCount(body_->mesh.triangleCount(), Tiling::kTileTriangles);
  received_tiles_.resize(tiles);
  received_regions_.resize(tiling_ ? tiling_->regionCount()
                                   : blockCount(tiles, Tiling::kRegionTiles));
  finite_regions_.resize(received_regions_.size());
  if (slot_count_ < tiles) {
    slot_count_ = tiles + tiles / 4;
    slots_ = std::make_unique<Slot[]>(slot_count_);
  }
  first_of_tile_.clear();
  first_of_region_.clear();
  if (!tiling_) return;
  const auto leastOf = [](const auto& list, std::size_t begin, std::size_t end) {
    return *std::min_element(list.begin() + static_cast<std::ptrdiff_t>(begin),
                             list.begin() + static_cast<std::ptrdiff_t>(end));
  };
  for (std::size_t t = 0; t < tiles; ++t) {
    first_of_tile_.push_back(
        leastOf(tiling_->triangle, tiling_->tile_begin[t], tiling_->tile_begin[t + 1]));
  }
  for (std::size_t r = 0; r < tiling_->regionCount(); ++r) {
    first_of_region_.push_back(leastOf(first_of_tile_, tileBegin(r), tileEnd(r)));
  }
}

// Finds which tiles and regions lie within one part.
void BodyTiles::findParts() {
  part_of_tile_.clear();
  part_of_region_.clear();
  const std::vector<PartId>& parts = body_->parts;
  if (parts.empty()) return;
  const auto join = [](std::uint16_t& of_all, std::uint32_t part, bool is_first) {
    if (!is_first && of_all != part) part = kSeveralParts;
    of_all = static_cast<std::uint16_t>(part);
  };
  for (std::size_t tile = 0; tile < tileCount(); ++tile) {
    const std::size_t begin = tiling_ ? tiling_->tile_begin[tile] : tile * Tiling::kTileTriangles;
    const std::size_t end = tiling_ ? tiling_->tile_begin[tile + 1]
                                    : least(begin + Tiling::kTileTriangles, parts.size());
    part_of_tile_.push_back(0);
    for (std::size_t slot = begin; slot < end; ++slot) {
      join(part_of_tile_.back(), parts[tiling_ ? tiling_->triangle[slot] : slot], slot == begin);
    }
  }
  for (std::size_t region = 0; region < received_regions_.size(); ++region) {
    part_of_region_.push_back(0);
    for (std::size_t tile = tileBegin(region); tile < tileEnd(region); ++tile) {
      join(part_of_region_.back(), part_of_tile_[tile], tile == tileBegin(region));
    }
  }
}

// Makes the boxes in the body's own frame. Returns false if the limit is over.
bool BodyTiles::receive(const CycleLimit& limit) {
  constexpr std::size_t kBlock = 2;  // regions, some 3 000 vertices
  vertices_revision_ = 0;
  parallelBlocks(limit, received_regions_.size(), kBlock,
                 [this](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t r = begin; r < end; ++r) receiveRegion(r);
                 });
  if (limit.wasOver()) return false;
  received_finite_ =
      std::find(finite_regions_.begin(), finite_regions_.end(), 0) == finite_regions_.end();
  vertices_revision_ = body_->vertices_revision;
  return true;
}

// Makes the boxes of one region and of its tiles. Regions are independent, so threads share them.
void BodyTiles::receiveRegion(std::size_t region) {
  bool all_finite = true;
  Aabb whole;
  for (std::size_t tile = tileBegin(region); tile < tileEnd(region); ++tile) {
    receiveTile(tile, all_finite);
    whole.include(received_tiles_[tile]);
  }
  received_regions_[region] = whole;
  finite_regions_[region] = all_finite ? 1 : 0;
}

void BodyTiles::receiveTile(std::size_t tile, bool& all_finite) {
  const TriangleMesh& mesh = body_->mesh;
  const std::uint32_t* vertex;
  std::size_t count;
  if (tiling_) {
    vertex = tiling_->vertex.data() + tiling_->vertex_begin[tile];
    count = tiling_->vertex_begin[tile + 1] - tiling_->vertex_begin[tile];
  } else {
    const std::size_t first = tile * Tiling::kTileTriangles;
    vertex = mesh.triangles.data() + 3 * first;
    count = 3 * least(Tiling::kTileTriangles, mesh.triangleCount() - first);
  }
  received_tiles_[tile] =
      receivedBox(mesh.vertices.data(), mesh.vertexCount(), vertex, count, all_finite);
}

// The box ends at the largest float32, so it holds all finite vertices even if the pose makes
// others infinite.
Aabb BodyTiles::posed(const Aabb& received) const {
  if (received.empty() || is_identity_) return received;
  const Aabb box = posedBox(received, body_->pose, false);
  return {{atLeastFinite(box.min.x), atLeastFinite(box.min.y), atLeastFinite(box.min.z)},
          {atMostFinite(box.max.x), atMostFinite(box.max.y), atMostFinite(box.max.z)}};
}

// Several threads may ask for the same tile. The first one makes it while the others spin, which is
// short. The number of the cycle is stored with release order after the tile is complete, so a
// thread that reads it with acquire order sees the whole tile.
const PosedTile& BodyTiles::tile(std::size_t tile) const {
  Slot& slot = slots_[tile];
  if (slot.made.load(std::memory_order_acquire) == cycle_) return *slot.tile;
  while (slot.busy.test_and_set(std::memory_order_acquire)) {
  }
  const struct Release {  // also if memory is short
    std::atomic_flag& busy;
    ~Release() { busy.clear(std::memory_order_release); }
  } release{slot.busy};
  if (slot.made.load(std::memory_order_relaxed) != cycle_) {
    if (slot.tile == nullptr) slot.tile = std::make_unique<PosedTile>();
    if (tiling_) {
      slot.tile->make(*tiling_, tile, PosedBody(*body_));
    } else {
      slot.tile->makeRun(body_->mesh, tile * Tiling::kTileTriangles, PosedBody(*body_));
    }
    slot.made.store(cycle_, std::memory_order_release);
  }
  return *slot.tile;
}

}  // namespace deformable_contact_monitor
