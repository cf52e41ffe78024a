// The scene on the device: what changed goes up, the rest stays.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/detector.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/memory/device_vertices.cuh"
#include "cuda/memory/host_copy.cuh"
#include "cuda/memory/scene_tables.cuh"

namespace deformable_contact_monitor {

// Bodies of which some pair is enabled, and what is constant while topology and pairs are. Their
// vertices and triangles are numbered through, in the bodies' order.
class DeviceScene {
 public:
  // Fills in `arrays`, whose memory it makes grow by `sizes`. All must outlive this. `device`: the
  // current one's number.
  DeviceScene(int device, DeviceMemory& memory, CycleSizes& sizes, SceneArrays& arrays)
      : device_(device), memory_(memory), sizes_(sizes), arrays_(arrays) {}

  // What laying the scene out changed.
  struct Change {
    bool any = false;
    // Triangles that there were not before: of bodies that were not there, or have more of them.
    std::uint64_t more_triangles = 0;
    std::uint64_t fewer_triangles = 0;     // that there are not any more, the same way
    std::uint64_t replaced_triangles = 0;  // of bodies that have as many, but others
  };

  // Lays the scene out anew if other pairs are enabled, or the topology of a body of theirs
  // changed; `fans`: certificates are asked for. The sizes grow, nothing comes to the device yet.
  // Throws CudaError if it is too large.
  Change layOut(const Scene& scene, Motion motion, bool fans);

  // The arrays to their sizes; sends what was laid out, from the first body on that has changed. It
  // may not be laid out anew before that has arrived.
  void sendLayout(const Scene& scene, cudaStream_t stream);

  // Once bodies are sent: the triangles by tiles, where a layout has changed.
  void group(cudaStream_t stream);
  // Behind a cycle, where nobody waits for it: the same where bodies may have another shape by now,
  // that is, vertices were sent in so many cycles since.
  static constexpr std::uint32_t kGroupedFor = 64;
  void groupAgain(cudaStream_t stream);

  // Once bodies are sent: what certificates need, where a layout with `fans` did not find it
  // before.
  void findFans(cudaStream_t stream);

  // Sends vertices that changed, with `copies`; those that are on the device are copied there, in
  // the stream. Throws std::invalid_argument, naming the body, where they cannot be read.
  void sendVertices(const Scene& scene, Motion motion, HostCopies& copies, cudaStream_t stream);
  // What was sent may not have arrived: all vertices and bodies are to be sent again.
  void forgetSent();

  // Whether the scene that was laid out has vertices on the device.
  bool anyFromDevice() const { return any_from_device_; }
  // That scene, with all of them brought to the host: takes milliseconds.
  Scene onHost(const Scene& scene, cudaStream_t stream) const;

  // Sends all poses, and margins or pads, with `copies`. `scale`: of the clustering.
  void sendBodies(const Scene& scene, Motion motion, const SceneScale& scale, HostCopies& copies);

  std::uint32_t triangleCount() const { return arrays_.triangle_count; }
  std::uint32_t groupCount() const { return tables_.group_count; }
  bool anySelf() const { return tables_.any_self; }
  // Scene::anyMargin() and anyPad() of the scene that was sent.
  BodyLengths anyLengths() const { return any_; }

  // What results call two triangles of the scene.
  TrianglePair pairOf(TriangleIndex a, TriangleIndex b) const {
    const ListedBody body_a = bodyOf(tables_.listed.data(), arrays_.body_count, a);
    const ListedBody body_b = bodyOf(tables_.listed.data(), arrays_.body_count, b);
    return {body_a.id, a.value - body_a.first_triangle, body_b.id, b.value - body_b.first_triangle};
  }

 private:
  // A body on the device, and what it was laid out for.
  struct LaidOutBody {
    BodyId id;
    std::uint64_t topology_revision;
    std::uint32_t triangles;

    bool operator==(const LaidOutBody& o) const {
      return id == o.id && topology_revision == o.topology_revision;
    }
    bool operator!=(const LaidOutBody& o) const { return !(*this == o); }
  };

  static Change changeOf(const std::vector<LaidOutBody>& before,
                         const std::vector<LaidOutBody>& now);
  std::vector<LaidOutBody> bodiesOf(const Scene& scene) const;
  bool isLaidOut(const Scene& scene) const;
  Change layOutAnew(const Scene& scene);
  void addCorners(const Scene& scene, HostCopies& copies);
  void sizeFans(const Scene& scene);
  void growArrays(cudaStream_t stream);
  void sendEarlierVertices(const Scene& scene, HostCopies& copies);
  void addEarlierBodies(const Scene& scene, HostCopies& copies);

  const int device_;
  DeviceMemory& memory_;
  CycleSizes& sizes_;
  SceneArrays& arrays_;

  bool laid_out_ = false;  // what is below is on the device, but for these tables
  SceneTables tables_;
  std::uint32_t first_new_ = 0;       // body whose corners are the first to be sent
  std::uint32_t grouped_ = 0;         // so are the tiles of so many bodies
  std::uint32_t deformed_ = 0;        // cycles since then that sent vertices
  bool has_fans_ = false;             // so are the rings
  bool bodies_sent_ = false;          // so is what staged_bodies_ holds
  std::uint64_t pairs_revision_ = 0;  // of the enabled pairs
  std::vector<std::pair<BodyId, BodyId>> pairs_;
  std::vector<LaidOutBody> laid_out_bodies_;  // per body on the device
  std::vector<std::uint64_t> vertices_;       // revisions on the device, per body of the scene
  std::vector<std::uint64_t> earlier_;        // the same of Body::earlier; 0: none
  bool any_from_device_ = false;
  BodyLengths any_{};

  DeviceBuffer<unsigned char> scratch_;
  DeviceVertexCopier copier_;
  PinnedBuffer<std::uint32_t> staged_corners_;
  PinnedBuffer<float> staged_vertices_;
  PinnedBuffer<DeviceBody> staged_bodies_;
  PinnedBuffer<float> staged_earlier_vertices_;
  PinnedBuffer<EarlierBody> staged_earlier_bodies_;
};

}  // namespace deformable_contact_monitor
