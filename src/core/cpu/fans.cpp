#include "core/cpu/fans.h"

#include <cstddef>

#include "core/parallel.h"
#include "core/predicates/vertex_fan.h"

namespace deformable_contact_monitor {
namespace {

// As isFanCertified() wants it.
class RingOfVertex {
 public:
  // `vertices`: the body's.
  RingOfVertex(const VertexFans& fans, const Vec3f* vertices, std::uint32_t v)
      : ring_(&fans.ring[fans.begin[v]]),
        size_(fans.begin[v + 1] - fans.begin[v]),
        vertices_(vertices) {}
  std::uint32_t size() const { return size_; }
  const Vec3f& ring(std::uint32_t k) const { return vertices_[ring_[k]]; }
  bool closed() const { return ring_[0] == ring_[size_ - 1]; }

 private:
  const std::uint32_t* ring_;
  std::uint32_t size_;
  const Vec3f* vertices_;
};

}  // namespace

// No vertex of another index has the same place in the mesh as one that is not repeated: so the
// ring tells of all triangles there.
void FanCertifier::certifyBody(const VertexFans& fans, std::uint32_t first, std::uint32_t count,
                               const CycleLimit& limit, WorkingSet& set) {
  std::uint32_t* const id = set.vertex_id.data() + first;
  repeated_.assign(count, 0);
  for (std::uint32_t v = 0; v < count; ++v) {
    if (id[v] != first + v) repeated_[v] = repeated_[id[v] - first] = 1;
  }
  constexpr std::size_t kBlock = 1024;
  parallelBlocks(limit, count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    const Vec3f* const vertices = set.vertices.data() + first;
    for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
      if (repeated_[v] == 0 && isFanCertified(vertices[v], RingOfVertex(fans, vertices, v))) {
        id[v] |= kFanCertified;
      }
    }
  });
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
      known.topology_revision = body.topology_revision;
    }
    if (known.fans.begin.empty()) continue;
    certifyBody(known.fans, set.first_vertex[id],
                static_cast<std::uint32_t>(body.mesh.vertexCount()), limit, set);
  }
}

}  // namespace deformable_contact_monitor
