// The bodies of a check on the device: which pairs are looked at, tiles, vertices and boxes.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/scene.h"
#include "core/state_checker.h"
#include "core/tiling.h"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_vertices.cuh"
#include "cuda/states/state_arrays.cuh"

namespace deformable_contact_monitor {

// Belongs to one checker. Data stays on the device from check to check: tiles until a topology
// changes, vertices and boxes until they change.
class StateScene {
 public:
  using IdPair = std::pair<BodyId, BodyId>;

  // Brings the device up to date with a scene, for these pairs of bodies, ascending, of which at
  // least one is moved. Throws CudaError, and std::invalid_argument for vertices on a device that
  // cannot be read. Waits for the stream if something has changed. Returns false if the limits were
  // over while tiles were made.
  bool update(const Scene& scene, const std::vector<IdPair>& pairs, const StateBatch& batch,
              const Limits& limits, int device, cudaStream_t stream);

  // Sends everything in the next check.
  void forget();

  // Fills in the arrays of the bodies.
  void addTo(StateArrays* arrays);

  const std::vector<IdPair>& pairs() const { return pairs_; }
  const std::vector<RejectedPart>& rejected() const { return rejected_; }
  // Returns whether the pose of a body that is not moved takes a vertex beyond float32.
  bool leavesFloats() const { return leaves_floats_; }
  // Returns the number of a slot's triangle in its body.
  std::uint32_t triangleOf(std::uint32_t slot) const { return slot_triangle_[slot]; }

 private:
  // What the lists of tiles and pairs depend on.
  struct Key {
    std::uint64_t pairs_revision;
    std::vector<IdPair> pairs;
    std::vector<BodyId> moved;
    std::vector<std::uint64_t> revisions;  // of topologies and parts, by body of ids_
    std::vector<float> lengths_m;          // radii and margins

    bool operator==(const Key& o) const {
      return pairs_revision == o.pairs_revision && pairs == o.pairs && moved == o.moved &&
             revisions == o.revisions && lengths_m == o.lengths_m;
    }
  };
  static Key keyOf(const Scene& scene, const std::vector<IdPair>& pairs, const StateBatch& batch);

  bool layOut(const Scene& scene, const StateBatch& batch, const Limits& limits);
  bool layOutBodies(const Scene& scene, const StateBatch& batch, const Limits& limits);
  void layOutTiles(const Scene& scene);
  void layOutParts(const Scene& scene);
  void layOutPairs(const Scene& scene, const StateBatch& batch);
  void sendLists(cudaStream_t stream);
  bool sendVertices(const Scene& scene, int device, cudaStream_t stream);
  void countRejected(const Scene& scene, cudaStream_t stream);

  Key key_{};
  bool is_laid_out_ = false;
  std::vector<IdPair> pairs_;
  std::vector<BodyId> ids_;                                         // of the bodies, ascending
  std::vector<std::uint32_t> first_vertex_;                         // by body
  std::map<std::uint64_t, std::shared_ptr<const Tiling>> tilings_;  // by topology_revision
  std::vector<std::uint64_t> sent_vertices_;                        // vertices_revision by body

  std::vector<StateBody> bodies_;
  std::vector<DeviceStatePair> state_pairs_;
  std::vector<std::uint32_t> walk_begin_, walk_pair_, moved_body_;
  std::vector<RigidTransform> still_poses_;
  std::vector<std::uint32_t> slot_triangle_, slot_vertex_, slot_part_, tile_body_, part_bits_;
  std::vector<float> slot_margin_;
  std::vector<StateRegion> regions_;
  std::uint32_t vertex_count_ = 0, part_words_ = 0;
  std::vector<RejectedPart> rejected_;
  bool leaves_floats_ = false;

  DeviceVerticesReader device_vertices_;
  DeviceBuffer<StateBody> d_bodies_;
  DeviceBuffer<DeviceStatePair> d_pairs_;
  DeviceBuffer<std::uint32_t> d_walk_begin_, d_walk_pair_, d_moved_body_;
  DeviceBuffer<RigidTransform> d_still_poses_;
  DeviceBuffer<std::uint32_t> d_slot_triangle_, d_slot_vertex_, d_slot_part_, d_tile_body_;
  DeviceBuffer<std::uint32_t> d_part_bits_, d_received_, d_live_, d_tile_least_;
  DeviceBuffer<float> d_slot_margin_, d_vertices_, d_corner_;
  DeviceBuffer<StateRegion> d_regions_;
  DeviceBuffer<Aabb> d_tile_box_, d_region_box_, d_body_box_;
  DeviceBuffer<Vec3f> d_tile_point_;
};

}  // namespace deformable_contact_monitor
