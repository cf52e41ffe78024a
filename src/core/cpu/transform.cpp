#include "core/cpu/transform.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "core/common/posed_body.h"
#include "core/rules/common_motion.h"

namespace deformable_contact_monitor {

namespace {

constexpr std::size_t kBlock = 2048;  // triangles or vertices

// Makes a list at least `size` long. It never shrinks it, which would cost a pass over the new
// elements later.
template <class T>
void growTo(std::size_t size, std::vector<T>& to) {
  if (to.size() < size) to.resize(size);
}

// Makes room for that many triangles.
void growTriangles(std::size_t size, WorkingSet& set) {
  growTo(3 * size, set.corners);
  growTo(size, set.body);
  growTo(size, set.triangle);
  growTo(size, set.boxes);
  if (set.parts != nullptr) growTo(size, set.part);
}

// Cuts all lists to the lengths that are in use.
void cutTo(std::size_t vertices, std::size_t triangles, bool moving, WorkingSet& set) {
  set.vertices.resize(vertices);
  set.earlier.resize(moving ? vertices : 0);
  set.vertex_id.resize(vertices);
  set.corners.resize(3 * triangles);
  set.body.resize(triangles);
  set.triangle.resize(triangles);
  set.boxes.resize(triangles);
  set.part.resize(set.parts != nullptr ? triangles : 0);
}

// Transforms `count` vertices of a body into the scene frame, to places from `first` on.
void transformVertices(const PosedBody& posed, std::size_t first, std::size_t count,
                       const CycleLimit& limit, std::vector<Vec3f>& vertices) {
  growTo(first + count, vertices);
  parallelBlocks(limit, count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) vertices[first + i] = posed.vertex(i);
  });
}

// Fills in everything but the box and the part of the set's i-th triangle, which is triangle t of
// a body.
void place(const Body& body, BodyId id, std::uint32_t t, std::size_t i, WorkingSet& set) {
  const std::uint32_t* corner = &body.mesh.triangles[3 * std::size_t{t}];
  for (int k = 0; k < 3; ++k) set.corners[3 * i + k] = set.first_vertex[id] + corner[k];
  set.body[i] = id;
  set.triangle[i] = t;
}

// Fills in the parts of a body's triangles, which have the places from `begin` to `end` in the set.
void noteParts(const Body& body, BodyId id, std::size_t begin, std::size_t end, WorkingSet& set) {
  for (std::size_t i = begin; i < end; ++i) {
    const PartId part = body.parts.empty() ? PartId{0} : body.parts[set.triangle[i]];
    set.part[i] = set.parts->numberOf(id, part);
  }
}

// Returns whether triangles of a body are left out because their parts take no part.
bool hasIdleParts(const WorkingSet& set, BodyId id) {
  return set.parts != nullptr && !set.parts->allTakePart(id);
}

// Finds on which sides of the partners' common box each vertex of a body lies; `first` is where
// they begin in the set.
template <class Primitive>
void findSides(const Body& body, float growth_m, const PartnerBoxes<BoxOf<Primitive>>& partners,
               std::size_t first, const CycleLimit& limit, const WorkingSet& set,
               std::vector<std::uint8_t>& sides) {
  sides.resize(body.mesh.vertexCount());
  parallelBlocks(limit, sides.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    const Vec3f* const now = &set.vertices[first];
    if constexpr (kIsMoving<Primitive>) {  // on one side at both ends
      const Vec3f* const earlier = &set.earlier[first];
      const BoxSides from(partners.bound.from, growth_m), to(partners.bound.to, growth_m);
      for (std::size_t i = begin; i < end; ++i) sides[i] = from.of(earlier[i]) & to.of(now[i]);
    } else {
      const BoxSides bound(partners.bound, growth_m);
      for (std::size_t i = begin; i < end; ++i) sides[i] = bound.of(now[i]);
    }
  });
}

// Returns the box that the working set stores: of a moving triangle that of all it passes, without
// the common motion.
const Aabb& setBoxOf(const Aabb& box, const WorkingSet& /*set*/) { return box; }
Aabb setBoxOf(const MovingBox& box, const WorkingSet& set) {
  return sweptBox(box, set.common_motion);
}

}  // namespace

// Fills in the ids of a body's vertices. Ids are compared only within one body, so a body without
// self-contact gets ids that are all different, at no cost.
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

// Fills blocks_ with the triangles that take part and meet a partner's box. Three vertices on the
// same side of the partners' common box settle most triangles without a box of their own.
template <class Primitive>
void WorkingSetBuilder::chooseTriangles(const Body& body, BodyId id, std::uint32_t first,
                                        const PartnerBoxes<BoxOf<Primitive>>& partners,
                                        const CycleLimit& limit, const WorkingSet& set) {
  const TriangleMesh& mesh = body.mesh;
  const bool has_sides = !partners.self && body_boxes_.allFinite(id);
  if (has_sides) findSides<Primitive>(body, growth_m_, partners, first, limit, set, sides_);
  const bool has_idle = hasIdleParts(set, id), has_parts = !body.parts.empty();
  blocks_.resize(blockCount(mesh.triangleCount(), kBlock));
  const auto chooseBlock = [&](std::size_t b, std::size_t begin, std::size_t end) {
    Block& block = blocks_[b];
    block.triangle.clear();
    block.boxes.clear();
    block.rejected = 0;
    block.rejected_parts.clear();
    for (std::size_t t = begin; t < end; ++t) {
      if (has_idle && !set.parts->takesPart(set.parts->of(id, t))) continue;
      const std::uint32_t* corner = &mesh.triangles[3 * t];
      if (has_sides && (sides_[corner[0]] & sides_[corner[1]] & sides_[corner[2]]) != 0) continue;
      const Primitive posed =
          set.primitiveOf<Primitive>(first + corner[0], first + corner[1], first + corner[2]);
      if (!isFinite(posed)) {
        ++block.rejected;
        if (has_parts) block.rejected_parts.push_back(body.parts[t]);
        continue;
      }
      const BoxOf<Primitive> box = inflated(boxOf(posed), growth_m_);
      if (!partners.meet(box)) continue;
      block.triangle.push_back(static_cast<std::uint32_t>(t));
      block.boxes.push_back(setBoxOf(box, set));
    }
  };
  parallelBlocks(limit, mesh.triangleCount(), kBlock, chooseBlock);
}

// Adds the triangles in blocks_ to the set, and returns how many triangles were rejected.
std::uint64_t WorkingSetBuilder::addChosen(const Body& body, BodyId id, const CycleLimit& limit,
                                           WorkingSet& set) {
  std::uint64_t rejected = 0;
  for (Block& block : blocks_) {
    block.place = triangle_count_;
    triangle_count_ += block.triangle.size();
    rejected += block.rejected;
    for (const PartId part : block.rejected_parts) ++of_part_[part];
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

// Adds all triangles of a body whose vertices are finite and which may touch itself: nothing of it
// is culled.
template <class Primitive>
void WorkingSetBuilder::addAllTriangles(const Body& body, BodyId id, const CycleLimit& limit,
                                        WorkingSet& set) {
  const std::size_t first = triangle_count_;
  triangle_count_ += body.mesh.triangleCount();
  growTriangles(triangle_count_, set);
  const auto addBlock = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      place(body, id, static_cast<std::uint32_t>(t), first + t, set);
      const std::uint32_t* corner = &set.corners[3 * (first + t)];
      const Primitive posed = set.primitiveOf<Primitive>(corner[0], corner[1], corner[2]);
      const auto box = boxOf(posed);
      set.boxes[first + t] = setBoxOf(growth_m_ > 0 ? inflated(box, growth_m_) : box, set);
    }
  };
  parallelBlocks(limit, body.mesh.triangleCount(), kBlock, addBlock);
}

// Transforms the vertices of a body that meets a partner, and adds its triangles.
template <class Primitive>
void WorkingSetBuilder::addBody(const Scene& scene, BodyId id,
                                const PartnerBoxes<BoxOf<Primitive>>& partners,
                                const CycleLimit& limit, WorkingSet& set, Counters& counters) {
  const Body& body = scene.body(id);
  const auto first = static_cast<std::uint32_t>(vertex_count_);
  vertex_count_ += body.mesh.vertexCount();
  set.first_vertex[id] = first;
  transformVertices(PosedBody(body), first, body.mesh.vertexCount(), limit, set.vertices);
  if (kIsMoving<Primitive>) {
    transformVertices(PosedBody::earlier(body), first, body.mesh.vertexCount(), limit, set.earlier);
  }
  identifyVertices(body, partners.self, kIsMoving<Primitive>, first, limit, set);
  const std::size_t before = triangle_count_;
  std::uint64_t rejected = 0;
  if (partners.self && body_boxes_.allFinite(id) && !hasIdleParts(set, id)) {
    addAllTriangles<Primitive>(body, id, limit, set);
  } else {
    chooseTriangles<Primitive>(body, id, first, partners, limit, set);
    if (limit.wasOver()) return;
    rejected = addChosen(body, id, limit, set);
  }
  if (set.parts != nullptr) noteParts(body, id, before, triangle_count_, set);
  if (limit.over()) return;
  counters.posed += body.mesh.triangleCount();
  counters.rejected += rejected;
  counters.culled += body.mesh.triangleCount() - (triangle_count_ - before) - rejected;
}

// Counts the triangles of a body that meets no partner; its vertices are not transformed.
template <class Primitive>
void WorkingSetBuilder::countLeftOut(const Scene& scene, BodyId id, const WorkingSet& set,
                                     const CycleLimit& limit, Counters& counters) {
  constexpr std::size_t kBlock = 1 << 16;
  const std::size_t count = scene.body(id).mesh.triangleCount();
  const PosedBody body(scene.body(id)), earlier = PosedBody::earlier(scene.body(id));
  const std::vector<PartId>& parts = scene.body(id).parts;
  std::uint64_t rejected = 0;
  const std::size_t to_check = body_boxes_.allFinite(id) ? 0 : count;
  serialBlocks(limit, to_check, kBlock, [&](std::size_t begin, std::size_t end) {
    for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
      if (set.parts != nullptr && !set.parts->takesPart(set.parts->of(id, t))) continue;
      if (isFinite(body.triangle(t)) && (!kIsMoving<Primitive> || isFinite(earlier.triangle(t)))) {
        continue;
      }
      ++rejected;
      if (!parts.empty()) ++of_part_[parts[t]];
    }
  });
  counters.rejected += rejected;
  counters.culled += count - rejected;
}

// Moves the counts of a body's rejected triangles to the list, if it has named parts.
void WorkingSetBuilder::listRejectedParts(const Body& body, BodyId id) {
  if (body.parts.empty()) return;
  for (const PartId part : body.listed_parts) {
    if (of_part_[part] > 0) rejected_parts_.push_back({id, part, of_part_[part]});
    of_part_[part] = 0;
  }
}

// Goes through the bodies in order, so that the set is in (body, triangle) order.
template <class Primitive>
void WorkingSetBuilder::build(const Scene& scene, const Options& options, WorkingSet& set,
                              Counters& counters, const CycleLimit& limit) {
  body_boxes_.update<Primitive>(scene, options, limit);
  set.parts = scene.partsMatter() ? std::make_shared<const PartTable>(scene) : nullptr;
  set.first_vertex.assign(scene.bodyCount(), 0);
  set.common_motion = kIsMoving<Primitive> ? commonMotionOf(scene) : Vec3f();
  vertex_count_ = triangle_count_ = 0;
  rejected_parts_.clear();
  for (BodyId id = 0; id < scene.bodyCount() && !limit.over(); ++id) {
    if (!scene.takesPart(id)) continue;
    growth_m_ = growthOf<Primitive>(scene.body(id), options);
    const PartnerBoxes<BoxOf<Primitive>> partners = body_boxes_.partnersOf<Primitive>(scene, id);
    if (partners.self || !partners.boxes.empty()) {
      addBody<Primitive>(scene, id, partners, limit, set, counters);
    } else {
      countLeftOut<Primitive>(scene, id, set, limit, counters);
    }
    listRejectedParts(scene.body(id), id);
  }
  cutTo(vertex_count_, triangle_count_, kIsMoving<Primitive>, set);
}

Vec3f commonMotionOf(const Scene& scene) {
  constexpr std::size_t kSample = 512;
  std::size_t count = 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id)) count += scene.body(id).mesh.vertexCount();
  }
  const std::size_t step = std::max<std::size_t>(1, count / kSample);
  std::vector<Vec3d> motions;
  std::size_t first = step / 2;  // of the body's vertices, one in `step`
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const Body& body = scene.body(id);
    const PosedBody from = PosedBody::earlier(body), to(body);
    const std::size_t vertices = body.mesh.vertexCount();
    std::size_t i = first;
    for (; i < vertices; i += step) {
      const Vec3f a = from.vertex(i), b = to.vertex(i);
      if (isFinite(a) && isFinite(b)) motions.push_back(toDouble(b) - toDouble(a));
    }
    first = i - vertices;
  }
  return commonMotion(motions);
}

// The instantiations are exported here because a template whose arguments are hidden would be
// hidden too.
template DCM_EXPORT void WorkingSetBuilder::build<Triangle>(const Scene&, const Options&,
                                                            WorkingSet&, Counters&,
                                                            const CycleLimit&);
template DCM_EXPORT void WorkingSetBuilder::build<MovingTriangle>(const Scene&, const Options&,
                                                                  WorkingSet&, Counters&,
                                                                  const CycleLimit&);

}  // namespace deformable_contact_monitor
