// The scene on the device: what changed goes up, the rest stays.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/body_groups.h"
#include "core/detector.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_vertices.cuh"

namespace deformable_contact_monitor {

// Bodies of which some pair is enabled, and what is constant while topology and pairs are. Their
// vertices and triangles are numbered through, in the bodies' order.
class DeviceScene {
 public:
  // Fills in `arrays`, whose memory it makes grow by `sizes`. All must outlive this. `device`: the
  // current one's number.
  DeviceScene(int device, DeviceMemory& memory, CycleSizes& sizes, SceneArrays& arrays)
      : device_(device), memory_(memory), sizes_(sizes), arrays_(arrays) {}

  // Lays the scene out anew if other pairs are enabled, or the topology of a body of theirs
  // changed; true if so. Then arrays may have moved, as they may if the motion is another one than
  // last time. Throws CudaError if it is too large.
  bool layOut(const Scene& scene, Motion motion, cudaStream_t stream);

  // Sends vertices that changed; those that are on the device are copied there. Throws
  // std::invalid_argument, naming the body, where they cannot be read.
  void sendVertices(const Scene& scene, Motion motion, cudaStream_t stream);

  // Whether the scene that was sent has vertices on the device.
  bool anyFromDevice() const { return any_from_device_; }
  // That scene, with all of them brought to the host: takes milliseconds.
  Scene onHost(const Scene& scene, cudaStream_t stream) const;

  // Sends all poses, and margins or pads. `scale`: of the clustering.
  void sendBodies(const Scene& scene, Motion motion, const SceneScale& scale, cudaStream_t stream);

  std::uint32_t triangleCount() const { return arrays_.triangle_count; }
  std::uint32_t groupCount() const { return group_count_; }
  bool anySelf() const { return any_self_; }
  // Scene::anyMargin() and anyPad() of the scene that was sent.
  BodyLengths anyLengths() const { return any_; }

  // What results call two triangles of the scene.
  TrianglePair pairOf(TriangleIndex a, TriangleIndex b) const {
    const ListedBody body_a = bodyOf(listed_.data(), arrays_.body_count, a);
    const ListedBody body_b = bodyOf(listed_.data(), arrays_.body_count, b);
    return {body_a.id, a.value - body_a.first_triangle, body_b.id, b.value - body_b.first_triangle};
  }

 private:
  // What the device gets of the pairs.
  struct PairTables {
    std::vector<BodyIndex> partners;
    std::vector<std::uint32_t> group_mask, pair_enabled;
  };

  bool isLaidOut(const Scene& scene) const;
  std::vector<std::uint64_t> topologyOf(const Scene& scene) const;
  PairTables tabulatePairs(const Scene& scene);
  void addPairs(const Scene& scene, const BodyGroups& groups, BodyIndex row, PairTables& tables);
  void layOutPairs(const Scene& scene, cudaStream_t stream);
  void numberMeshes(const Scene& scene);
  void layOutMeshes(const Scene& scene, cudaStream_t stream);
  void layOutFans(const Scene& scene, cudaStream_t stream);
  void growArrays();
  void sendEarlierVertices(const Scene& scene, cudaStream_t stream);
  void sendEarlierBodies(const Scene& scene, cudaStream_t stream);

  const int device_;
  DeviceMemory& memory_;
  CycleSizes& sizes_;
  SceneArrays& arrays_;

  bool laid_out_ = false;             // what is below is on the device
  bool bodies_sent_ = false;          // so is what staged_bodies_ holds
  std::uint64_t pairs_revision_ = 0;  // of the enabled pairs
  std::vector<std::pair<BodyId, BodyId>> pairs_;
  std::vector<std::uint64_t> topology_;  // revisions, per body on the device
  std::vector<std::uint64_t> vertices_;  // revisions on the device, per body of the scene
  std::vector<std::uint64_t> earlier_;   // the same of Body::earlier; 0: none
  std::vector<BodyId> taking_part_;      // bodies of the scene, per body on the device
  std::vector<DeviceBody> body_;         // per body on the device
  std::vector<ListedBody> listed_;       // per body on the device
  std::uint32_t vertex_count_ = 0, group_count_ = 0;
  bool any_self_ = false, any_from_device_ = false;
  BodyLengths any_{};

  DeviceVertexCopier copier_;
  PinnedBuffer<float> staged_vertices_;
  PinnedBuffer<DeviceBody> staged_bodies_;
  PinnedBuffer<float> staged_earlier_vertices_;
  PinnedBuffer<EarlierBody> staged_earlier_bodies_;
};

}  // namespace deformable_contact_monitor
