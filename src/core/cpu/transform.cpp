#include "core/cpu/transform.h"

#include <algorithm>
#include <numeric>

#include "core/common/parallel.h"
#include "core/common/posed_body.h"
#include "core/cpu/box_sides.h"
#include "core/cpu/common_motion.h"
#include "core/rules/common_motion.h"

namespace deformable_contact_monitor {

namespace {

constexpr std::size_t kBlock = 2048;  // triangles or vertices

// To at least so many, without a pass over what is there.
template <class T>
void growTo(std::size_t size, std::vector<T>& to) {
  if (to.size() < size) to.resize(size);
}

void growTriangles(std::size_t size, WorkingSet& set) {
  growTo(3 * size, set.corners);
  growTo(size, set.body);
  growTo(size, set.triangle);
  growTo(size, set.boxes);
}

void cutTo(std::size_t vertices, std::size_t triangles, bool moving, WorkingSet& set) {
  set.vertices.resize(vertices);
  set.earlier.resize(moving ? vertices : 0);
  set.vertex_id.resize(vertices);
  set.corners.resize(3 * triangles);
  set.body.resize(triangles);
  set.triangle.resize(triangles);
  set.boxes.resize(triangles);
}

void poseVertices(const PosedBody& posed, std::size_t first, std::size_t count,
                  const CycleLimit& limit, std::vector<Vec3f>& vertices) {
  growTo(first + count, vertices);
  parallelBlocks(limit, count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) vertices[first + i] = posed.vertex(i);
  });
}

// All of the i-th of the set but its box: triangle t of a body.
void place(const Body& body, BodyId id, std::uint32_t t, std::size_t i, WorkingSet& set) {
  const std::uint32_t* corner = &body.mesh.triangles[3 * std::size_t{t}];
  for (int k = 0; k < 3; ++k) set.corners[3 * i + k] = set.first_vertex[id] + corner[k];
  set.body[i] = id;
  set.triangle[i] = t;
}

// Of each vertex from `first` on, beside the hull of the partners.
template <class Hull>
void findSides(const Body& body, const PartnerBoxes<BoxOf<Hull>>& partners, std::size_t first,
               const CycleLimit& limit, const WorkingSet& set, std::vector<std::uint8_t>& sides) {
  const float growth_m = growthOf<Hull>(body);
  sides.resize(body.mesh.vertexCount());
  parallelBlocks(limit, sides.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    const Vec3f* const now = &set.vertices[first];
    if constexpr (kIsMoving<Hull>) {  // on one side at both ends
      const Vec3f* const earlier = &set.earlier[first];
      const BoxSides from(partners.hull.from, growth_m), to(partners.hull.to, growth_m);
      for (std::size_t i = begin; i < end; ++i) sides[i] = from.of(earlier[i]) & to.of(now[i]);
    } else {
      const BoxSides hull(partners.hull, growth_m);
      for (std::size_t i = begin; i < end; ++i) sides[i] = hull.of(now[i]);
    }
  });
}

const Aabb& setBoxOf(const Aabb& box, const WorkingSet& /*set*/) { return box; }
Aabb setBoxOf(const MovingBox& box, const WorkingSet& set) {
  return sweptBox(box, set.common_motion);
}

}  // namespace

// Only a body's own triangles ask which vertices they share.
void WorkingSetBuilder::identifyVertices(const Body& body, bool self, bool moving,
                                         std::uint32_t first, const CycleLimit& limit,
                                         WorkingSet& set) {
  const std::size_t count = body.mesh.vertexCount();
  growTo(first + count, set.vertex_id);
  std::uint32_t* const id = set.vertex_id.data() + first;
  if (!self) {
    std::iota(id, id + count, first);
    return;
  }
  if (moving && body.earlier && !body.earlier->vertices.empty()) {
    identity_.identify(body.mesh.vertices, body.earlier->vertices, least_equal_, limit);
  } else {
    identity_.identify(body.mesh.vertices, least_equal_, limit);
  }
  parallelBlocks(limit, count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) id[i] = first + least_equal_[i];
  });
}

// Fills blocks_ with the triangles that meet a partner's box.
template <class Hull>
void WorkingSetBuilder::chooseTriangles(const Body& body, BodyId id, std::uint32_t first,
                                        const PartnerBoxes<BoxOf<Hull>>& partners,
                                        const CycleLimit& limit, const WorkingSet& set) {
  const TriangleMesh& mesh = body.mesh;
  const float growth_m = growthOf<Hull>(body);
  const bool has_sides = !partners.self && body_boxes_.allFinite(id);
  if (has_sides) findSides<Hull>(body, partners, first, limit, set, sides_);
  blocks_.resize(blockCount(mesh.triangleCount(), kBlock));
  const auto chooseBlock = [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    block.triangle.clear();
    block.boxes.clear();
    block.rejected = 0;
    for (std::size_t t = begin; t < end; ++t) {
      const std::uint32_t* corner = &mesh.triangles[3 * t];
      if (has_sides && (sides_[corner[0]] & sides_[corner[1]] & sides_[corner[2]]) != 0) continue;
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

// Adds what blocks_ hold. How many triangles were rejected.
std::uint64_t WorkingSetBuilder::addChosen(const Body& body, BodyId id, const CycleLimit& limit,
                                           WorkingSet& set) {
  std::uint64_t rejected = 0;
  for (Block& block : blocks_) {
    block.place = triangle_count_;
    triangle_count_ += block.triangle.size();
    rejected += block.rejected;
  }
  growTriangles(triangle_count_, set);
  parallelBlocks(limit, blocks_.size(), 1, [&](std::size_t b, std::size_t, std::size_t) {
    const Block& block = blocks_[b];
    for (std::size_t i = 0; i < block.triangle.size(); ++i) {
      place(body, id, block.triangle[i], block.place + i, set);
    }
    std::copy(block.boxes.begin(), block.boxes.end(),
              set.boxes.begin() + static_cast<std::ptrdiff_t>(block.place));
  });
  return rejected;
}

// Of a body whose vertices are all finite, and which is its own partner.
template <class Hull>
void WorkingSetBuilder::addAllTriangles(const Body& body, BodyId id, const CycleLimit& limit,
                                        WorkingSet& set) {
  const std::size_t first = triangle_count_;
  triangle_count_ += body.mesh.triangleCount();
  growTriangles(triangle_count_, set);
  const float growth_m = growthOf<Hull>(body);
  const auto addBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      place(body, id, static_cast<std::uint32_t>(t), first + t, set);
      const std::uint32_t* corner = &set.corners[3 * (first + t)];
      const Hull posed = set.hullOf<Hull>(corner[0], corner[1], corner[2]);
      set.boxes[first + t] = setBoxOf(inflated(boxOf(posed), growth_m), set);
    }
  };
  parallelBlocks(limit, body.mesh.triangleCount(), kBlock, addBlock);
}

template <class Hull>
void WorkingSetBuilder::addBody(const Scene& scene, BodyId id,
                                const PartnerBoxes<BoxOf<Hull>>& partners, const CycleLimit& limit,
                                WorkingSet& set, Counters& counters) {
  const Body& body = scene.body(id);
  const auto first = static_cast<std::uint32_t>(vertex_count_);
  vertex_count_ += body.mesh.vertexCount();
  set.first_vertex[id] = first;
  poseVertices(PosedBody(body), first, body.mesh.vertexCount(), limit, set.vertices);
  if (kIsMoving<Hull>) {
    poseVertices(PosedBody::earlier(body), first, body.mesh.vertexCount(), limit, set.earlier);
  }
  identifyVertices(body, partners.self, kIsMoving<Hull>, first, limit, set);
  const std::size_t before = triangle_count_;
  std::uint64_t rejected = 0;
  if (partners.self && body_boxes_.allFinite(id)) {
    addAllTriangles<Hull>(body, id, limit, set);
  } else {
    chooseTriangles<Hull>(body, id, first, partners, limit, set);
    if (limit.wasOver()) return;
    rejected = addChosen(body, id, limit, set);
  }
  if (limit.over()) return;
  counters.posed += body.mesh.triangleCount();
  counters.rejected += rejected;
  counters.culled += body.mesh.triangleCount() - (triangle_count_ - before) - rejected;
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
  set.first_vertex.assign(scene.bodyCount(), 0);
  set.common_motion = kIsMoving<Hull> ? commonMotionOf(scene) : Vec3f();
  vertex_count_ = triangle_count_ = 0;
  for (BodyId id = 0; id < scene.bodyCount() && !limit.over(); ++id) {
    if (!scene.takesPart(id)) continue;
    const PartnerBoxes<BoxOf<Hull>> partners = body_boxes_.partnersOf<Hull>(scene, id);
    if (partners.self || !partners.boxes.empty()) {
      addBody<Hull>(scene, id, partners, limit, set, counters);
    } else {
      countLeftOut<Hull>(scene, id, limit, counters);
    }
  }
  cutTo(vertex_count_, triangle_count_, kIsMoving<Hull>, set);
}

// Exported here, for a template is not visible outside that has arguments which are not.
template DCM_EXPORT void WorkingSetBuilder::build<Triangle>(const Scene&, WorkingSet&, Counters&,
                                                            const CycleLimit&);
template DCM_EXPORT void WorkingSetBuilder::build<MovingTriangle>(const Scene&, WorkingSet&,
                                                                  Counters&, const CycleLimit&);

}  // namespace deformable_contact_monitor
