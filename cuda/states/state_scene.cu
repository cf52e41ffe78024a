#include <algorithm>
#include <limits>

#include "core/bounds/pair_radii.h"
#include "core/common/part_table.h"
#include "core/rules/margins.h"
#include "core/states/state_input.h"
#include "cuda/device/warp.cuh"
#include "cuda/states/state_kernels.cuh"
#include "cuda/states/state_scene.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kMostSlots = 1U << 28;  // so that no index of 32 bits wraps

std::uint32_t placeOf(const std::vector<BodyId>& ids, BodyId id) {
  return static_cast<std::uint32_t>(std::lower_bound(ids.begin(), ids.end(), id) - ids.begin());
}

// Copies a list to the device. The list must stay until the stream has been waited for.
template <class T>
void send(const std::vector<T>& from, DeviceBuffer<T>* to, cudaStream_t stream) {
  to->grow(std::max<std::size_t>(1, from.size()), stream);
  to->upload(from.data(), from.size(), stream);
}

}  // namespace

StateScene::Key StateScene::keyOf(const Scene& scene, const std::vector<IdPair>& pairs,
                                  const StateBatch& batch) {
  Key key{scene.pairsRevision(), pairs, batch.moved, {}, {}};
  for (const auto& [a, b] : pairs) {
    for (const BodyId id : {a, b}) {
      const Body& body = scene.body(id);
      key.revisions.push_back(body.topology_revision);
      key.revisions.push_back(body.parts_revision);
      key.lengths_m.push_back(body.radius_m);
      key.lengths_m.push_back(body.margin_m);
      key.lengths_m.push_back(body.own_margin_m);
      for (const auto& [part, margin_m] : body.part_margins_m) {
        key.revisions.push_back(part);
        key.lengths_m.push_back(margin_m);
      }
    }
  }
  return key;
}

void StateScene::forget() {
  is_laid_out_ = false;
  tilings_.clear();
}

bool StateScene::update(const Scene& scene, const std::vector<IdPair>& pairs,
                        const StateBatch& batch, const Limits& limits, int device,
                        cudaStream_t stream) {
  Key key = keyOf(scene, pairs, batch);
  const bool is_new = !is_laid_out_ || !(key == key_);
  if (is_new) {
    is_laid_out_ = false;
    key_ = std::move(key);
    pairs_ = pairs;
    if (!layOut(scene, batch, limits)) return false;
    sendLists(stream);
  }
  const bool any_sent = sendVertices(scene, device, stream);
  is_laid_out_ = true;
  if (!is_new && !any_sent) return true;
  StateArrays arrays{};
  addTo(&arrays);
  launchStateBodies(arrays, stream);
  countRejected(scene, stream);
  return true;
}

bool StateScene::layOut(const Scene& scene, const StateBatch& batch, const Limits& limits) {
  ids_.clear();
  for (const auto& [a, b] : pairs_) ids_.insert(ids_.end(), {a, b});
  std::sort(ids_.begin(), ids_.end());
  ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
  if (!layOutBodies(scene, batch, limits)) return false;
  layOutTiles(scene);
  layOutParts(scene);
  layOutPairs(scene, batch);
  sent_vertices_.assign(ids_.size(), std::numeric_limits<std::uint64_t>::max());
  still_poses_.assign(ids_.size(), RigidTransform());
  return true;
}

// Makes tilings where they are missing, and numbers tiles, regions and vertices. Returns false if
// the limits are over.
bool StateScene::layOutBodies(const Scene& scene, const StateBatch& batch, const Limits& limits) {
  std::map<std::uint64_t, std::shared_ptr<const Tiling>> tilings;
  bodies_.clear();
  first_vertex_.clear();
  std::uint64_t tiles = 0, regions = 0, vertices = 0;
  for (const BodyId id : ids_) {
    const Body& body = scene.body(id);
    std::shared_ptr<const Tiling>& tiling = tilings[body.topology_revision];
    const auto known = tilings_.find(body.topology_revision);
    if (known != tilings_.end()) tiling = known->second;
    if (!tiling) tiling = std::make_shared<const Tiling>(tilingBySurface(body.mesh, limits));
    if (tiling->tileCount() == 0 && !body.mesh.triangles.empty()) return false;
    const auto moved = std::find(batch.moved.begin(), batch.moved.end(), id);
    first_vertex_.push_back(static_cast<std::uint32_t>(vertices));
    bodies_.push_back(
        {static_cast<std::uint32_t>(tiles), static_cast<std::uint32_t>(tiling->tileCount()),
         static_cast<std::uint32_t>(regions), static_cast<std::uint32_t>(tiling->regionCount()),
         moved == batch.moved.end() ? kNone
                                    : static_cast<std::uint32_t>(moved - batch.moved.begin())});
    tiles += tiling->tileCount();
    regions += tiling->regionCount();
    vertices += body.mesh.vertices.size() / 3;
    if (tiles * kWarp > kMostSlots || vertices > kMostSlots) {
      throw CudaError(BackendFault::kSceneTooLarge,
                      "the bodies are too large to check their states on CUDA");
    }
  }
  vertex_count_ = static_cast<std::uint32_t>(vertices);
  tilings_ = std::move(tilings);
  return true;
}

void StateScene::layOutTiles(const Scene& scene) {
  const std::size_t tiles =
      bodies_.empty() ? 0 : bodies_.back().first_tile + bodies_.back().tile_count;
  const std::size_t slots = tiles * kWarp;
  slot_triangle_.assign(slots, kNone);
  slot_vertex_.assign(3 * slots, 0);
  tile_body_.assign(tiles, 0);
  regions_.clear();
  for (std::uint32_t i = 0; i < ids_.size(); ++i) {
    const TriangleMesh& mesh = scene.body(ids_[i]).mesh;
    const Tiling& tiling = *tilings_.at(scene.body(ids_[i]).topology_revision);
    const std::uint32_t first = bodies_[i].first_tile;
    for (std::uint32_t r = 0; r < tiling.regionCount(); ++r) {
      regions_.push_back(
          {first + tiling.region_begin[r], tiling.region_begin[r + 1] - tiling.region_begin[r]});
    }
    for (std::uint32_t tile = 0; tile < tiling.tileCount(); ++tile) {
      tile_body_[first + tile] = i;
      std::size_t slot = std::size_t{first + tile} * kWarp;
      for (std::uint32_t s = tiling.tile_begin[tile]; s < tiling.tile_begin[tile + 1]; ++s) {
        const std::size_t triangle = tiling.triangle[s];
        slot_triangle_[slot] = tiling.triangle[s];
        for (std::size_t k = 0; k < 3; ++k) {
          slot_vertex_[k * slots + slot] = first_vertex_[i] + mesh.triangles[3 * triangle + k];
        }
        ++slot;
      }
    }
  }
}

// Numbers the parts, and gives triangles their margins, where the scene makes a difference of them.
void StateScene::layOutParts(const Scene& scene) {
  slot_part_.clear();
  slot_margin_.clear();
  part_bits_.clear();
  const auto ofSlots = [&](const auto& value, auto* to) {
    to->assign(slot_triangle_.size(), {});
    for (std::size_t slot = 0; slot < slot_triangle_.size(); ++slot) {
      if (slot_triangle_[slot] == kNone) continue;
      (*to)[slot] = value(ids_[tile_body_[slot / kWarp]], slot_triangle_[slot]);
    }
  };
  if (scene.partsMatter()) {
    const PartTable table(scene);
    part_bits_ = table.bits();
    part_words_ = table.pairs().row_words;
    ofSlots([&](BodyId id, std::uint32_t t) { return table.of(id, t); }, &slot_part_);
  }
  const bool has_margins = std::any_of(
      ids_.begin(), ids_.end(), [&](BodyId id) { return !scene.body(id).part_margins_m.empty(); });
  if (!has_margins) return;
  ofSlots(
      [&](BodyId id, std::uint32_t t) {
        const Body& body = scene.body(id);
        return body.marginOf(body.partOf(t));
      },
      &slot_margin_);
}

// Gives each pair to the warps of a moved body: to body b if a stands still.
void StateScene::layOutPairs(const Scene& scene, const StateBatch& batch) {
  state_pairs_.clear();
  std::vector<std::vector<std::uint32_t>> walks(batch.moved.size());
  for (const auto& [id_a, id_b] : pairs_) {
    const Body &a = scene.body(id_a), &b = scene.body(id_b);
    const PairRadii radii(a, b);
    const std::uint32_t at_a = placeOf(ids_, id_a), at_b = placeOf(ids_, id_b);
    const std::uint32_t moved =
        bodies_[at_a].moved != kNone ? bodies_[at_a].moved : bodies_[at_b].moved;
    walks[moved].push_back(static_cast<std::uint32_t>(state_pairs_.size()));
    state_pairs_.push_back(
        {at_a, at_b, radii.touch_m, pairMargin(a.margin_m, b.margin_m), radii.sum()});
  }
  walk_begin_.assign(1, 0);
  walk_pair_.clear();
  for (const std::vector<std::uint32_t>& walk : walks) {
    walk_pair_.insert(walk_pair_.end(), walk.begin(), walk.end());
    walk_begin_.push_back(static_cast<std::uint32_t>(walk_pair_.size()));
  }
  moved_body_.clear();
  for (const BodyId id : batch.moved) {
    const std::uint32_t place = placeOf(ids_, id);
    moved_body_.push_back(place < ids_.size() && ids_[place] == id ? place : kNone);
  }
}

void StateScene::sendLists(cudaStream_t stream) {
  send(bodies_, &d_bodies_, stream);
  send(state_pairs_, &d_pairs_, stream);
  send(walk_begin_, &d_walk_begin_, stream);
  send(walk_pair_, &d_walk_pair_, stream);
  send(moved_body_, &d_moved_body_, stream);
  send(slot_triangle_, &d_slot_triangle_, stream);
  send(slot_vertex_, &d_slot_vertex_, stream);
  send(slot_part_, &d_slot_part_, stream);
  send(slot_margin_, &d_slot_margin_, stream);
  send(part_bits_, &d_part_bits_, stream);
  send(tile_body_, &d_tile_body_, stream);
  send(regions_, &d_regions_, stream);
  const std::size_t tiles = std::max<std::size_t>(1, tile_body_.size());
  d_received_.grow(tiles, stream);
  d_live_.grow(tiles, stream);
  d_tile_box_.grow(tiles, stream);
  d_tile_point_.grow(tiles, stream);
  d_tile_least_.grow(tiles, stream);
  d_corner_.grow(9 * kWarp * tiles, stream);
  d_region_box_.grow(std::max<std::size_t>(1, regions_.size()), stream);
  d_body_box_.grow(std::max<std::size_t>(1, ids_.size()), stream);
  d_vertices_.grow(std::max<std::size_t>(3, std::size_t{3} * vertex_count_), stream);
  checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
}

// Sends vertices and poses of bodies that stand still. Returns whether any have changed.
bool StateScene::sendVertices(const Scene& scene, int device, cudaStream_t stream) {
  bool any = false;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const Body& body = scene.body(ids_[i]);
    if (sent_vertices_[i] == body.vertices_revision) continue;
    if (body.device_vertices) DeviceVerticesReader::requireReadable(body, device);
  }
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const Body& body = scene.body(ids_[i]);
    if (bodies_[i].moved == kNone && !(still_poses_[i] == body.pose)) {
      still_poses_[i] = body.pose;
      any = true;
    }
    if (sent_vertices_[i] == body.vertices_revision) continue;
    sent_vertices_[i] = std::numeric_limits<std::uint64_t>::max();
    const std::size_t first = std::size_t{3} * first_vertex_[i];
    if (body.device_vertices) {
      device_vertices_.copy(body, d_vertices_.data() + first, stream);
    } else {
      d_vertices_.upload(body.mesh.vertices.data(), body.mesh.vertices.size(), stream, first);
    }
    sent_vertices_[i] = body.vertices_revision;
    any = true;
  }
  if (any) send(still_poses_, &d_still_poses_, stream);
  return any || d_still_poses_.size() == 0;
}

// Fills in rejected_ and leaves_floats_ from what the device says of each tile.
void StateScene::countRejected(const Scene& scene, cudaStream_t stream) {
  const std::size_t tiles = tile_body_.size();
  std::vector<std::uint32_t> received(tiles), live(tiles);
  d_received_.download(received.data(), tiles, stream);
  d_live_.download(live.data(), tiles, stream);
  checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  rejected_.clear();
  leaves_floats_ = false;
  std::map<std::pair<BodyId, PartId>, std::uint64_t> counts;
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    leaves_floats_ = leaves_floats_ || received[tile] != live[tile];
    const BodyId id = ids_[tile_body_[tile]];
    for (std::size_t lane = 0; lane < kWarp; ++lane) {
      const std::uint32_t triangle = slot_triangle_[tile * kWarp + lane];
      if (triangle == kNone || (received[tile] >> lane & 1) != 0) continue;
      ++counts[{id, scene.body(id).partOf(triangle)}];
    }
  }
  for (const auto& [at, count] : counts) {
    if (partTakesPart(scene, pairs_, at.first, at.second)) {
      rejected_.push_back({at.first, at.second, count});
    }
  }
}

void StateScene::addTo(StateArrays* arrays) {
  arrays->body_count = static_cast<std::uint32_t>(ids_.size());
  arrays->moved_count = static_cast<std::uint32_t>(walk_begin_.size() - 1);
  arrays->pair_count = static_cast<std::uint32_t>(pairs_.size());
  arrays->tile_count = static_cast<std::uint32_t>(tile_body_.size());
  arrays->region_count = static_cast<std::uint32_t>(regions_.size());
  arrays->bodies = d_bodies_.data();
  arrays->pairs = d_pairs_.data();
  arrays->walk_begin = d_walk_begin_.data();
  arrays->walk_pair = d_walk_pair_.data();
  arrays->moved_body = d_moved_body_.data();
  arrays->still_pose = d_still_poses_.data();
  arrays->vertices = d_vertices_.data();
  arrays->slot_triangle = d_slot_triangle_.data();
  arrays->slot_vertex = d_slot_vertex_.data();
  arrays->slot_part = slot_part_.empty() ? nullptr : d_slot_part_.data();
  arrays->slot_margin = slot_margin_.empty() ? nullptr : d_slot_margin_.data();
  arrays->parts = {d_part_bits_.data(), part_words_};
  arrays->tile_body = d_tile_body_.data();
  arrays->regions = d_regions_.data();
  arrays->received = d_received_.data();
  arrays->live = d_live_.data();
  arrays->corner = d_corner_.data();
  arrays->tile_box = d_tile_box_.data();
  arrays->region_box = d_region_box_.data();
  arrays->body_box = d_body_box_.data();
  arrays->tile_point = d_tile_point_.data();
  arrays->tile_least = d_tile_least_.data();
}

}  // namespace deformable_contact_monitor
