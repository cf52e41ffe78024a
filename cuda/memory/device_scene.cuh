// Keeps a copy of the scene on the device, and sends only what has changed.
#pragma once

#include <algorithm>
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

// Holds the bodies that are in some enabled pair, and tables that stay while topology and pairs do.
// The vertices and triangles of all bodies are numbered consecutively, in the bodies' order.
// Belongs to one detector. A cycle calls layOut(), sendLayout(), sendVertices(), sendBodies(),
// makeTiles() and findFans().
class DeviceScene {
 public:
  // Fills in `arrays`, whose memory it grows to `sizes`. All arguments must outlive this. `device`
  // is the number of the current device.
  DeviceScene(int device, DeviceMemory& memory, CycleSizes& sizes, SceneArrays& arrays)
      : device_(device), memory_(memory), sizes_(sizes), arrays_(arrays) {}

  // The difference between the layout and the one before it.
  struct Change {
    bool any = false;
    // New triangles: of new bodies, or of bodies that have more than before.
    std::uint64_t more_triangles = 0;
    std::uint64_t fewer_triangles = 0;     // triangles that are gone, counted in the same way
    std::uint64_t replaced_triangles = 0;  // triangles of a body whose topology changed
  };

  // Lays the scene out anew if the enabled pairs or the topology of their bodies have changed.
  // `fans`: whether certified fans are needed. Sizes grow, but nothing is sent yet. Throws
  // CudaError if the scene is too large.
  Change layOut(const Scene& scene, Motion motion, bool fans);

  // Grows the arrays and sends the layout, from the first changed body on. The next layOut() must
  // not be called before this has arrived.
  void sendLayout(const Scene& scene, cudaStream_t stream);

  // Groups the triangles of new and changed bodies into tiles. Call it after the bodies were sent.
  void makeTiles(cudaStream_t stream);
  // Rebuilds all tiles if vertices were sent in kCyclesOfTiles cycles since the last time, because
  // the bodies may have deformed. Call it when nobody waits for the stream.
  static constexpr std::uint32_t kCyclesOfTiles = 64;
  void makeTilesAgain(cudaStream_t stream);

  // Builds the vertex rings that certified fans need, unless the layout has them already. Call it
  // after the bodies were sent.
  void findFans(cudaStream_t stream);

  // Sends vertices that have changed, with `copies`. Vertices that are on the device already are
  // copied there, in the stream. Throws std::invalid_argument, naming the body, if they cannot be
  // read.
  void sendVertices(const Scene& scene, Motion motion, HostCopies& copies, cudaStream_t stream);
  // Makes the next cycle send all vertices and bodies, because earlier copies may not have arrived.
  void forgetSent();

  // Returns whether the scene that was laid out has vertices on the device.
  bool anyFromDevice() const { return any_from_device_; }
  // Returns the scene with all vertices brought to the host, which takes milliseconds.
  Scene onHost(const Scene& scene, cudaStream_t stream) const;

  // Sends all poses, and margins or pads, with `copies`. `scale`: the scale of the clusters.
  void sendBodies(const Scene& scene, const Options& options, const SceneScale& scale,
                  HostCopies& copies);

  const SceneTables& tables() const { return tables_; }
  std::uint32_t triangleCount() const { return arrays_.triangle_count; }
  std::uint32_t groupCount() const { return tables_.group_count; }
  bool anySelf() const { return tables_.any_self; }
  // Returns whether a cycle searches for equal vertices before it sweeps. It does not if a cycle of
  // this layout found few vertices that are equal to another one, and either pairs of triangles
  // that share a vertex are skipped, or none do by their numbers (not in swept motion). Then the
  // vertices of the pairs that pass the filters are compared, which is faster as long as few of
  // these pairs share one.
  bool searchesEqualVertices(const Options& options) const;
  KnownIdentities knownIdentities(const Options& options) const {
    if (searchesEqualVertices(options)) return KnownIdentities::kAll;
    return tables_.any_self_mesh ? KnownIdentities::kNumbers : KnownIdentities::kNone;
  }
  // Learns from a cycle that searched for equal vertices, or from one that did not.
  void setEqualVertices(const CycleCounters& counted, bool searched) {
    if (searched) {
      repeated_vertices_ = counted.repeated_vertices;
    } else {
      sharing_pairs_ = std::max(sharing_pairs_, counted.sharing_pairs);
    }
  }
  // Returns whether the scene that was sent has margins within which pairs are listed, and pads.
  BodyLengths anyLengths() const { return any_; }

  // Fills in result.rejected_parts after a cycle, whose counters the result has. Waits for the
  // device if some triangle of a body with parts may have been rejected.
  void listRejectedParts(const Scene& scene, DetectionResult& result, cudaStream_t stream) const;

  // Returns a pair of triangles as body ids and triangle numbers of those bodies.
  TrianglePair pairOf(TriangleIndex a, TriangleIndex b) const {
    const ListedBody body_a = bodyOf(tables_.listed.data(), arrays_.body_count, a);
    const ListedBody body_b = bodyOf(tables_.listed.data(), arrays_.body_count, b);
    return {body_a.id, a.value - body_a.first_triangle, body_b.id, b.value - body_b.first_triangle};
  }

 private:
  static constexpr std::uint32_t kNotCounted = ~std::uint32_t{0};

  // One body of the layout, and the topology that it was laid out with.
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
  bool hasPartsOf(const Scene& scene) const;
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

  bool laid_out_ = false;  // everything of the layout is on the device
  SceneTables tables_;
  std::uint32_t first_new_ = 0;  // the first body whose corners must be sent
  std::uint32_t tiled_ = 0;      // the number of bodies that have tiles
  std::uint32_t deformed_ = 0;   // cycles that sent vertices since the tiles were built
  bool has_fans_ = false;        // the vertex rings are on the device
  bool bodies_sent_ = false;     // the bodies in staged_bodies_ are on the device
  // The vertices that a cycle of this layout found equal to another one, and the most pairs that
  // shared such vertices in a cycle.
  std::uint32_t repeated_vertices_ = kNotCounted, sharing_pairs_ = 0;
  std::uint64_t pairs_revision_ = 0;  // of the enabled pairs
  std::vector<std::pair<BodyId, BodyId>> pairs_;
  std::vector<PartPair> disabled_parts_;
  std::vector<std::uint64_t> parts_;          // Body::parts_revision, for each body of the scene
  std::vector<LaidOutBody> laid_out_bodies_;  // for each body on the device
  std::vector<std::uint64_t> vertices_;       // revisions on the device, for each body of the scene
  std::vector<std::uint64_t> earlier_;        // the same for Body::earlier; 0 if not sent
  bool any_from_device_ = false;
  BodyLengths any_{};

  DeviceBuffer<unsigned char> scratch_;
  DeviceVerticesReader device_vertices_;
  PinnedBuffer<std::uint32_t> staged_corners_;
  PinnedBuffer<float> staged_vertices_;
  PinnedBuffer<DeviceBody> staged_bodies_;
  PinnedBuffer<float> staged_earlier_vertices_;
  PinnedBuffer<EarlierBody> staged_earlier_bodies_;
};

}  // namespace deformable_contact_monitor
