#include "core/cpu/fans.h"

#include <atomic>
#include <cstddef>

#include "core/common/parallel.h"
#include "core/cpu/lane_fan.h"
#include "core/predicates/vertex_fan.h"

namespace deformable_contact_monitor {

// Fills repeated_; leaves it empty where no vertex is.
void FanCertifier::markRepeated(const std::uint32_t* id, std::uint32_t first, std::uint32_t count,
                                const CycleLimit& limit) {
  constexpr std::size_t kBlock = 4096;
  repeated_.clear();
  std::atomic<bool> any{false};
  parallelBlocks(limit, count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    bool here = false;
    for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) here |= id[v] != first + v;
    if (here) any.store(true, std::memory_order_relaxed);
  });
  if (!any) return;
  repeated_.resize(count);
  for (std::uint32_t v = 0; v < count; ++v) {
    if (id[v] != first + v) repeated_[v] = repeated_[id[v] - first] = 1;
  }
}

// No vertex of another index has the same place in the mesh as one that is not repeated: so the
// ring tells of all triangles there.
void FanCertifier::certifyBody(const BodyFans& body, std::uint32_t first, std::uint32_t count,
                               const CycleLimit& limit, WorkingSet& set) {
  std::uint32_t* const id = set.vertex_id.data() + first;
  markRepeated(id, first, count, limit);
  constexpr std::size_t kBlock = 256;  // fours
  const Vec3f* const vertices = set.vertices.data() + first;
  const auto certifyBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t* const four = &body.fours[4 * i];
      const int certified = laneBits(areFansCertified(body.fans, four, vertices));
      for (int k = 0; k < 4; ++k) {
        const bool repeated = !repeated_.empty() && repeated_[four[k]] != 0;
        if ((certified >> k & 1) != 0 && !repeated) id[four[k]] |= kFanCertified;
      }
    }
  };
  parallelBlocks(limit, body.fours.size() / 4, kBlock, certifyBlock);
}

void FanCertifier::certify(const Scene& scene, WorkingSet& set, const CycleLimit& limit) {
  if (set.vertices.size() > kFanCertified) return;  // identities take all bits
  bodies_.resize(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount() && !limit.over(); ++id) {
    if (!scene.pairEnabled(id, id)) continue;
    const Body& body = scene.body(id);
    BodyFans& known = bodies_[id];
    if (known.topology_revision != body.topology_revision) {
      known.fans = vertexFans(body.mesh);
      known.fours.clear();
      if (!known.fans.begin.empty()) known.fours = foursAlike(known.fans);
      known.topology_revision = body.topology_revision;
    }
    certifyBody(known, set.first_vertex[id], static_cast<std::uint32_t>(body.mesh.vertexCount()),
                limit, set);
  }
}

}  // namespace deformable_contact_monitor
