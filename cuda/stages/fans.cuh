// Which vertices' fans are certified (stage sort): found beside the sort, for the sweep.
#pragma once

#include "core/predicates/vertex_fan.h"
#include "cuda/memory/cycle_arrays.cuh"

namespace deformable_contact_monitor {

// Whether certificates are looked for and used in a cycle of one state. Only exact verdicts are
// sure to be those that certificates tell.
__host__ __device__ inline bool usesFans(AdjacentPairs adjacent, Predicates predicates) {
  return adjacent == AdjacentPairs::kBeyondShared && predicates == Predicates::kExact;
}

// As isFanCertified() wants it. The first ring points are fetched together, for one after the other
// takes its time.
class RingOfVertex {
 public:
  __device__ RingOfVertex(const SceneArrays& scene, VertexIndex i)
      : scene_(scene),
        begin_(scene.fan_begin[i]),
        size_(scene.fan_begin[i + 1].value - begin_.value) {
    if (size_ == 0) return;
    VertexIndex at[kTogether];
#pragma unroll
    for (std::uint32_t k = 0; k < kTogether; ++k) {
      at[k] = scene.fan_ring[begin_ + min(k, size_ - 1)];
    }
    closed_ = at[0] == scene.fan_ring[begin_ + (size_ - 1)];
#pragma unroll
    for (std::uint32_t k = 0; k < kTogether; ++k) points_[k] = posedAt(at[k]);
  }
  __device__ std::uint32_t size() const { return size_; }
  __device__ Vec3f ring(std::uint32_t k) const {
    return k < kTogether ? points_[k] : posedAt(scene_.fan_ring[begin_ + k]);
  }
  __device__ bool closed() const { return closed_; }

 private:
  static constexpr std::uint32_t kTogether = 8;

  __device__ Vec3f posedAt(VertexIndex i) const {
    const float4 p = scene_.posed[i];
    return {p.x, p.y, p.z};
  }

  const SceneArrays& scene_;
  Place begin_;
  std::uint32_t size_;
  bool closed_ = false;
  Vec3f points_[kTogether];
};

// Reads scene.posed, scene.vertex_id and scene.repeated, which becomes zero; writes
// scene.fan_certified. No vertex of another index has the same place in the mesh as one that is not
// repeated: so the ring tells of all triangles there.
__device__ inline void certifyFan(const SceneArrays& scene, VertexIndex i) {
  const RingOfVertex ring(scene, i);
  const bool alone = scene.repeated[i] == 0 && scene.vertex_id[i] == i;
  scene.repeated[i] = 0;
  const float4 centre = scene.posed[i];
  scene.fan_certified[i] = alone && isFanCertified({centre.x, centre.y, centre.z}, ring) ? 1 : 0;
}

// Whether one of these vertices of `a` has a certified fan: then triangles that share it meet in
// what they share alone. x, y, z are vertices' identities.
__device__ inline bool isCertified(const SceneArrays& scene, const uint4& a, std::uint32_t bits) {
  const std::uint32_t ids[3] = {a.x, a.y, a.z};
  std::uint32_t certified = 0;
  for (int k = 0; k < 3; ++k) {
    if ((bits >> k & 1) != 0) certified |= scene.fan_certified[VertexIndex(ids[k])];
  }
  return certified != 0;
}

}  // namespace deformable_contact_monitor
