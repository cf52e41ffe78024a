#include "core/cpu/pose.h"

#include <algorithm>
#include <numeric>

#include "core/cpu/common_motion.h"
#include "core/parallel.h"
#include "core/posed_body.h"
#include "core/rules/common_motion.h"

namespace deformable_contact_monitor {

namespace {

void clear(WorkingSet& set, std::size_t body_count) {
  set.vertices.clear();
  set.earlier.clear();
  set.common_motion = Vec3f();
  set.vertex_id.clear();
  set.corners.clear();
  set.body.clear();
  set.triangle.clear();
  set.boxes.clear();
  set.first_vertex.assign(body_count, 0);
}

// Adds those of a body.
void poseVertices(const PosedBody& posed, std::size_t count, const CycleLimit& limit,
                  std::vector<Vec3f>& vertices) {
  constexpr std::size_t kBlock = 16384;
  const std::size_t first = vertices.size();
  vertices.resize(first + count);
  parallelBlocks(limit, count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) vertices[first + i] = posed.vertex(i);
  });
}

const Aabb& setBoxOf(const Aabb& box, const WorkingSet& /*set*/) { return box; }
Aabb setBoxOf(const MovingBox& box, const WorkingSet& set) {
  return sweptBox(box, set.common_motion);
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
void WorkingSetBuilder::identifyVertices(const Body& body, bool self, bool moving,
                                         std::uint32_t first, const CycleLimit& limit,
                                         WorkingSet& set) {
  set.vertex_id.resize(set.vertices.size());
  if (!self) {
    std::iota(set.vertex_id.begin() + first, set.vertex_id.end(), first);
    return;
  }
  if (moving && body.earlier && !body.earlier->vertices.empty()) {
    identity_.identify(body.mesh.vertices, body.earlier->vertices, least_equal_, limit);
  } else {
    identity_.identify(body.mesh.vertices, least_equal_, limit);
  }
  for (std::size_t i = 0; i < least_equal_.size(); ++i) {
    set.vertex_id[first + i] = first + least_equal_[i];
  }
}

// Fills blocks_ with the triangles that meet a partner's box.
template <class Hull>
void WorkingSetBuilder::chooseTriangles(const Body& body, std::uint32_t first,
                                        const PartnerBoxes<BoxOf<Hull>>& partners,
                                        const CycleLimit& limit, const WorkingSet& set) {
  constexpr std::size_t kBlock = 8192;
  const TriangleMesh& mesh = body.mesh;
  const float growth_m = growthOf<Hull>(body);
  blocks_.resize(blockCount(mesh.triangleCount(), kBlock));
  const auto chooseBlock = [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    block.triangle.clear();
    block.boxes.clear();
    block.rejected = 0;
    for (std::size_t t = begin; t < end; ++t) {
      const std::uint32_t* corner = &mesh.triangles[3 * t];
      const Hull posed = set.hullOf<Hull>(first + corner[0], first + corner[1], first + corner[2]);
      if (!isFinite(posed)) {
        ++block.rejected;
        continue;
      }
      const BoxOf<Hull> box = inflated(boxOf(posed), growth_m);
      if (!partners.meet(box)) continue;
      block.triangle.push_back(static_cast<std::uint32_t>(t));
      block.boxes.push_back(setBoxOf(box, set));
    }
  };
  parallelBlocks(limit, mesh.triangleCount(), kBlock, chooseBlock);
}

template <class Hull>
void WorkingSetBuilder::addBody(const Scene& scene, BodyId id,
                                const PartnerBoxes<BoxOf<Hull>>& partners, const CycleLimit& limit,
                                WorkingSet& set, Counters& counters) {
  const Body& body = scene.body(id);
  const auto first = static_cast<std::uint32_t>(set.vertices.size());
  set.first_vertex[id] = first;
  poseVertices(PosedBody(body), body.mesh.vertexCount(), limit, set.vertices);
  if (kIsMoving<Hull>) {
    poseVertices(PosedBody::earlier(body), body.mesh.vertexCount(), limit, set.earlier);
  }
  identifyVertices(body, partners.self, kIsMoving<Hull>, first, limit, set);
  chooseTriangles<Hull>(body, first, partners, limit, set);
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
template <class Hull>
void WorkingSetBuilder::countLeftOut(const Scene& scene, BodyId id, const CycleLimit& limit,
                                     Counters& counters) const {
  constexpr std::size_t kBlock = 1 << 16;
  const std::size_t count = scene.body(id).mesh.triangleCount();
  const PosedBody body(scene.body(id)), earlier = PosedBody::earlier(scene.body(id));
  std::uint64_t rejected = 0;
  const std::size_t to_check = body_boxes_.allFinite(id) ? 0 : count;
  serialBlocks(limit, to_check, kBlock, [&](std::size_t begin, std::size_t end) {
    for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
      rejected +=
          !isFinite(body.triangle(t)) || (kIsMoving<Hull> && !isFinite(earlier.triangle(t)));
    }
  });
  counters.rejected += rejected;
  counters.culled += count - rejected;
}

template <class Hull>
void WorkingSetBuilder::build(const Scene& scene, WorkingSet& set, Counters& counters,
                              const CycleLimit& limit) {
  body_boxes_.update<Hull>(scene, limit);
  clear(set, scene.bodyCount());
  if (kIsMoving<Hull>) set.common_motion = commonMotionOf(scene);
  for (BodyId id = 0; id < scene.bodyCount() && !limit.over(); ++id) {
    if (!scene.takesPart(id)) continue;
    const PartnerBoxes<BoxOf<Hull>> partners = body_boxes_.partnersOf<Hull>(scene, id);
    if (partners.self || !partners.boxes.empty()) {
      addBody<Hull>(scene, id, partners, limit, set, counters);
    } else {
      countLeftOut<Hull>(scene, id, limit, counters);
    }
  }
  if (!limit.wasOver()) fillCorners(scene, limit, set);
}

// Exported here, for a template is not visible outside that has arguments which are not.
template DCM_EXPORT void WorkingSetBuilder::build<Triangle>(const Scene&, WorkingSet&, Counters&,
                                                            const CycleLimit&);
template DCM_EXPORT void WorkingSetBuilder::build<MovingTriangle>(const Scene&, WorkingSet&,
                                                                  Counters&, const CycleLimit&);

}  // namespace deformable_contact_monitor
