// The scene on the device: what changed goes up, the rest stays.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene.h"
#include "cuda/memory/cycle_view.cuh"
#include "cuda/memory/device_buffer.cuh"

namespace deformable_contact_monitor {

// Bodies of which some pair is enabled, and what is constant while topology and pairs are.
class DeviceScene {
 public:
  // Lays the scene out anew if its topology or its pairs changed; true if so. Throws CudaError if
  // it is too large.
  bool layOut(const Scene& scene, cudaStream_t stream);

  // Sends vertices that changed, and all poses and margins. `scale`: of the clustering.
  void send(const Scene& scene, const SceneScale& scale, cudaStream_t stream);

  // Fills in the scene's part of the view.
  void view(CycleView& cycle);

  // A cycle's settings, but for scale and size rule.
  CycleParams params(const Options& options) const;

  std::uint32_t triangleCount() const { return triangle_count_; }
  bool anySelf() const { return any_self_; }
  bool anyMargin() const { return any_margin_; }
  bool empty() const { return triangle_count_ == 0; }
  std::uint64_t bytes() const;

  // The scene's body and triangle of a number.
  std::uint32_t bodyOf(std::uint32_t triangle) const { return body_of_[triangle]; }
  std::uint32_t localOf(std::uint32_t triangle) const {
    return triangle - first_triangle_[body_of_[triangle]];
  }

 private:
  void layOutPairs(const Scene& scene, cudaStream_t stream);
  void layOutMeshes(const Scene& scene, cudaStream_t stream);

  std::uint64_t pairs_revision_ = 0;
  std::vector<std::uint64_t> topology_;        // revisions, per body of the scene
  std::vector<std::uint64_t> vertices_;        // likewise: on the device
  std::vector<std::uint32_t> taking_part_;     // bodies of the scene
  std::vector<DeviceBody> body_;               // per body that takes part
  std::vector<std::uint32_t> first_triangle_;  // per body of the scene
  std::vector<std::uint32_t> body_of_;         // per triangle: body of the scene
  std::uint32_t vertex_count_ = 0, triangle_count_ = 0, class_count_ = 0, pair_row_ = 0;
  std::uint32_t vertex_block_count_ = 0, triangle_block_count_ = 0;
  bool classes_exact_ = true, any_self_ = false, any_margin_ = false;

  PinnedBuffer<float> staged_vertices_;
  PinnedBuffer<DeviceBody> staged_bodies_;
  DeviceBuffer<DeviceBody> bodies_;
  DeviceBuffer<std::uint32_t> partners_, class_mask_, pair_enabled_;
  DeviceBuffer<BodyBlock> vertex_blocks_, triangle_blocks_;
  DeviceBuffer<float> received_;
  DeviceBuffer<std::uint32_t> corners_, body_boxes_, far_count_, vertex_id_, identity_table_;
  DeviceBuffer<float4> posed_;
  DeviceBuffer<uint2> far_vertices_;
};

}  // namespace deformable_contact_monitor
