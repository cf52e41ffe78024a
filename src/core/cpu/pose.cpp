#include "core/cpu/pose.h"

#include <algorithm>
#include <numeric>

#include "core/parallel.h"
#include "core/posed_body.h"

namespace deformable_contact_monitor {

namespace {

void clear(WorkingSet& set, std::size_t body_count) {
  set.vertices.clear();
  set.vertex_id.clear();
  set.corners.clear();
  set.body.clear();
  set.triangle.clear();
  set.boxes.clear();
  set.first_vertex.assign(body_count, 0);
}

void poseVertices(const Body& body, std::uint32_t first, const CycleLimit& limit,
                  std::vector<Vec3f>& vertices) {
  constexpr std::size_t kBlock = 16384;
  const PosedBody posed(body);
  parallelBlocks(limit, body.mesh.vertexCount(), kBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t i = begin; i < end; ++i) vertices[first + i] = posed.vertex(i);
                 });
}

void fillCorners(const Scene& scene, const CycleLimit& limit, WorkingSet& set) {
  constexpr std::size_t kBlock = 1 << 16;
  set.corners.resize(3 * set.size());
  serialBlocks(limit, set.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::vector<std::uint32_t>& triangles = scene.body(set.body[i]).mesh.triangles;
      const std::uint32_t* corner = &triangles[3 * std::size_t{set.triangle[i]}];
      const std::uint32_t first = set.first_vertex[set.body[i]];
      for (int k = 0; k < 3; ++k) set.corners[3 * i + k] = first + corner[k];
    }
  });
}

}  // namespace

// Only a body's own triangles ask which vertices they share.
void WorkingSetBuilder::identifyVertices(const Body& body, bool self, std::uint32_t first,
                                         const CycleLimit& limit, WorkingSet& set) {
  set.vertex_id.resize(set.vertices.size());
  if (!self) {
    std::iota(set.vertex_id.begin() + first, set.vertex_id.end(), first);
    return;
  }
  identity_.identify(body.mesh.vertices, least_equal_, limit);
  for (std::size_t i = 0; i < least_equal_.size(); ++i) {
    set.vertex_id[first + i] = first + least_equal_[i];
  }
}

// Fills blocks_ with the triangles that meet a partner's box.
void WorkingSetBuilder::chooseTriangles(const Body& body, std::uint32_t first,
                                        const PartnerBoxes& partners, const CycleLimit& limit,
                                        const WorkingSet& set) {
  constexpr std::size_t kBlock = 8192;
  const TriangleMesh& mesh = body.mesh;
  blocks_.resize(blockCount(mesh.triangleCount(), kBlock));
  const auto chooseBlock = [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    block.triangle.clear();
    block.boxes.clear();
    block.rejected = 0;
    for (std::size_t t = begin; t < end; ++t) {
      const std::uint32_t* corner = &mesh.triangles[3 * t];
      const Triangle posed{{set.vertices[first + corner[0]], set.vertices[first + corner[1]],
                            set.vertices[first + corner[2]]}};
      if (!isFinite(posed)) {
        ++block.rejected;
        continue;
      }
      const Aabb box = inflated(boxOf(posed), body.margin_m);
      if (!partners.meet(box)) continue;
      block.triangle.push_back(static_cast<std::uint32_t>(t));
      block.boxes.push_back(box);
    }
  };
  parallelBlocks(limit, mesh.triangleCount(), kBlock, chooseBlock);
}

void WorkingSetBuilder::addBody(const Scene& scene, BodyId id, const PartnerBoxes& partners,
                                const CycleLimit& limit, WorkingSet& set, Counters& counters) {
  const Body& body = scene.body(id);
  const auto first = static_cast<std::uint32_t>(set.vertices.size());
  set.first_vertex[id] = first;
  set.vertices.resize(first + body.mesh.vertexCount());
  poseVertices(body, first, limit, set.vertices);
  identifyVertices(body, partners.self, first, limit, set);
  chooseTriangles(body, first, partners, limit, set);
  if (limit.over()) return;
  std::size_t kept = 0, rejected = 0;
  for (const Block& block : blocks_) {
    set.triangle.insert(set.triangle.end(), block.triangle.begin(), block.triangle.end());
    set.boxes.insert(set.boxes.end(), block.boxes.begin(), block.boxes.end());
    kept += block.triangle.size();
    rejected += block.rejected;
  }
  set.body.insert(set.body.end(), kept, id);
  counters.posed += body.mesh.triangleCount();
  counters.rejected += rejected;
  counters.culled += body.mesh.triangleCount() - kept - rejected;
}

// Of a body that meets no partner, and so is not posed.
void WorkingSetBuilder::countLeftOut(const Scene& scene, BodyId id, const CycleLimit& limit,
                                     Counters& counters) const {
  constexpr std::size_t kBlock = 1 << 16;
  const std::size_t count = scene.body(id).mesh.triangleCount();
  const PosedBody body(scene.body(id));
  std::uint64_t rejected = 0;
  const std::size_t to_check = body_boxes_.allFinite(id) ? 0 : count;
  serialBlocks(limit, to_check, kBlock, [&](std::size_t begin, std::size_t end) {
    for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
      rejected += !isFinite(body.triangle(t));
    }
  });
  counters.rejected += rejected;
  counters.culled += count - rejected;
}

void WorkingSetBuilder::build(const Scene& scene, WorkingSet& set, Counters& counters,
                              const CycleLimit& limit) {
  body_boxes_.update(scene, limit);
  clear(set, scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount() && !limit.over(); ++id) {
    if (!scene.takesPart(id)) continue;
    const PartnerBoxes partners = body_boxes_.partnersOf(scene, id);
    if (partners.self || !partners.boxes.empty()) {
      addBody(scene, id, partners, limit, set, counters);
    } else {
      countLeftOut(scene, id, limit, counters);
    }
  }
  if (!limit.wasOver()) fillCorners(scene, limit, set);
}

}  // namespace deformable_contact_monitor
