#include "core/cpu/fans.h"

#include <array>
#include <atomic>
#include <cstddef>

#include "core/common/parallel.h"
#include "core/predicates/vertex_fan.h"
#include "core/rules/fan_order.h"

namespace deformable_contact_monitor {
namespace {

// Returns the edges opposite to each vertex, grouped by vertex: those of v begin at begin[v] - v.
std::vector<FanEdge> oppositeEdges(const TriangleMesh& mesh,
                                   const std::vector<std::uint32_t>& begin) {
  std::vector<FanEdge> edges(mesh.triangles.size());
  std::vector<std::uint32_t> place(begin.begin(), begin.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const std::uint32_t* corner = &mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = corner[k];
      edges[place[v]++ - v] = {corner[(k + 1) % 3], corner[(k + 2) % 3]};
    }
  }
  return edges;
}

// Puts one point into each lane.
LanePoint spread(const Vec3f& p, const Vec3f& q, const Vec3f& r, const Vec3f& s) {
  return {FloatLanes{p.x, q.x, r.x, s.x}, FloatLanes{p.y, q.y, r.y, s.y},
          FloatLanes{p.z, q.z, r.z, s.z}};
}

std::uint32_t ringSize(const VertexFans& fans, std::uint32_t v) {
  return fans.begin[v + 1] - fans.begin[v];
}

bool isClosed(const VertexFans& fans, std::uint32_t v) {
  return fans.ring[fans.begin[v]] == fans.ring[fans.begin[v + 1] - 1];
}

constexpr std::uint32_t kMostRing = 33;  // most points of a ring that can be certified

}  // namespace

VertexFans vertexFans(const TriangleMesh& mesh) {
  VertexFans fans;
  const std::size_t count = mesh.vertexCount();
  if (mesh.triangles.size() + count > ~std::uint32_t{0}) return fans;
  fans.begin.assign(count + 1, 1);
  fans.begin[0] = 0;
  for (const std::uint32_t v : mesh.triangles) ++fans.begin[v + 1];
  for (std::size_t v = 0; v < count; ++v) fans.begin[v + 1] += fans.begin[v];
  fans.ring.resize(mesh.triangles.size() + count);
  std::vector<FanEdge> edges = oppositeEdges(mesh, fans.begin);
  constexpr std::size_t kBlock = 4096;
  parallelBlocks(count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
      std::uint32_t* ring = &fans.ring[fans.begin[v]];
      const std::uint32_t n = fans.begin[v + 1] - fans.begin[v] - 1;
      putRing(v, edges.data() + (fans.begin[v] - v), n, ring);
    }
  });
  return fans;
}

std::vector<std::uint32_t> foursAlike(const VertexFans& fans) {
  std::array<std::vector<std::uint32_t>, 2 * (kMostRing + 1)> kinds;
  const auto count = static_cast<std::uint32_t>(fans.begin.size()) - 1;
  for (std::uint32_t v = 0; v < count; ++v) {
    const std::uint32_t size = ringSize(fans, v);
    if (size < 2 || size > kMostRing || fans.ring[fans.begin[v]] == v) continue;
    kinds[2 * size + (isClosed(fans, v) ? 1 : 0)].push_back(v);
  }
  std::vector<std::uint32_t> fours;
  for (const std::vector<std::uint32_t>& kind : kinds) {
    fours.insert(fours.end(), kind.begin(), kind.end());
    while (fours.size() % 4 != 0) fours.push_back(kind.back());
  }
  return fours;
}

IntLanes areFansCertified(const VertexFans& fans, const std::uint32_t four[4],
                          const Vec3f* vertices) {
  const std::uint32_t size = ringSize(fans, four[0]);
  const std::uint32_t last = isClosed(fans, four[0]) ? size - 1 : size;
  const LanePoint centre =
      spread(vertices[four[0]], vertices[four[1]], vertices[four[2]], vertices[four[3]]);
  const std::uint32_t* ring[4];
  for (int i = 0; i < 4; ++i) ring[i] = &fans.ring[fans.begin[four[i]]];
  LanePoint to[kMostRing];
  LaneProduct product[kMostRing];
  LanePoint normal{};
  for (std::uint32_t k = 0; k < size; ++k) {
    to[k] = spread(vertices[ring[0][k]], vertices[ring[1][k]], vertices[ring[2][k]],
                   vertices[ring[3][k]]) -
            centre;
    if (k == 0) continue;
    product[k] = LaneProduct(to[k - 1], to[k]);
    const LanePoint& value = product[k].value();
    normal = {normal.x + value.x, normal.y + value.y, normal.z + value.z};
  }
  constexpr auto sizeOf = LaneProduct::sizeOf;
  const FloatLanes scale = most(most(sizeOf(normal.x), sizeOf(normal.y)), sizeOf(normal.z));
  const FloatLanes share = 1 / scale;
  normal = {normal.x * share, normal.y * share, normal.z * share};
  IntLanes certified = ~IntLanes{}, ahead{};
  for (std::uint32_t k = 1; k < size; ++k) {
    certified &= product[k].signWith(normal).positive;
    if (k >= last) continue;
    const LaneSigns side = LaneProduct(to[0], to[k]).signWith(normal);
    if (k > 1) certified &= ahead | side.negative;
    ahead = side.positive;
  }
  return certified;
}

// Marks the vertices that have an equal vertex with another index. repeated_ stays empty if there
// is none.
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

// Certifies one body. Only vertices that are not repeated may be certified: for these the ring of
// triangles by index is the ring of all triangles at that place.
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

// Goes through the bodies; fans of a new topology are listed first.
void FanCertifier::certify(const Scene& scene, WorkingSet& set, const CycleLimit& limit) {
  if (set.vertices.size() > kFanCertified)
    return;  // ids need all bits, so none is free for the mark
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
