#include "core/cpu/body_boxes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "core/common/parallel.h"
#include "core/common/posed_body.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kStep = 12;

// The box of coordinates x y z x y z ..., kStep of them at a time, so that the compiler turns the
// loop into vector instructions.
struct FiniteBound {
  float lo[kStep], hi[kStep],
      check[kStep] = {};  // becomes NaN with the first number that is not finite

  FiniteBound() {
    std::fill_n(lo, kStep, INFINITY);
    std::fill_n(hi, kStep, -INFINITY);
  }

  void add(std::size_t k, float x) {
    lo[k] = least(lo[k], x);
    hi[k] = most(hi[k], x);
    check[k] += x - x;
  }

  void add(const float* xyz, std::size_t count) {
    std::size_t i = 0;
    for (; i + kStep <= count; i += kStep) {
      for (std::size_t k = 0; k < kStep; ++k) add(k, xyz[i + k]);
    }
    for (; i < count; ++i) add(i % 3, xyz[i]);
  }
};

// Computes the box of all vertices. Returns false if some coordinate is not finite; then `box` is
// unspecified.
bool boundFinite(const HostList<float>& xyz, const CycleLimit& limit, Aabb& box) {
  constexpr std::size_t kBlock = kStep << 9;
  std::vector<FiniteBound> bounds(blockCount(xyz.size(), kBlock));
  parallelBlocks(limit, xyz.size(), kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    FiniteBound bound;
    bound.add(&xyz[begin], end - begin);
    bounds[b] = bound;
  });
  for (const FiniteBound& bound : bounds) {
    for (std::size_t k = 0; k < kStep; k += 3) {
      box.include(Aabb{{bound.lo[k], bound.lo[k + 1], bound.lo[k + 2]},
                       {bound.hi[k], bound.hi[k + 1], bound.hi[k + 2]}});
      if (!(bound.check[k] + bound.check[k + 1] + bound.check[k + 2] == 0)) return false;
    }
  }
  return true;
}

// Computes the box of the finite ones among every `every`-th vertex.
Aabb boxOfFiniteVertices(const HostList<float>& xyz, std::size_t every, const CycleLimit& limit) {
  constexpr std::size_t kBlock = 1 << 16;
  const std::size_t count = xyz.size() / 3;
  Aabb box;
  serialBlocks(limit, blockCount(count, every), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float* const v = &xyz[3 * every * i];
      const Vec3f vertex{v[0], v[1], v[2]};
      if (isFinite(vertex)) box.include(vertex);
    }
  });
  return box;
}

// Selects the part of a stored box that a primitive's box type needs.
template <class Box>
const Box& boxAs(const MovingBox& box) {
  if constexpr (std::is_same_v<Box, Aabb>) {
    return box.to;
  } else {
    return box;
  }
}

}  // namespace

// Updates the box of vertices as received if they have changed. Returns false if the limit is over;
// then, and if it throws, the box is made again next time, because it has only some of the
// vertices.
bool BodyBoxes::updateReceived(std::uint64_t revision, const HostList<float>& xyz,
                               const CycleLimit& limit, ReceivedBox& received) const {
  if (received.vertices_revision == revision) return true;
  const std::size_t every = xyz.size() / 3 / most_vertices_ + 1;
  received = ReceivedBox();
  ReceivedBox made{revision, Aabb(), every == 1};
  if (every == 1) made.all_finite = boundFinite(xyz, limit, made.box);
  if (!made.all_finite) made.box = boxOfFiniteVertices(xyz, every, limit);
  if (limit.wasOver()) return false;
  received = made;
  return true;
}

template <class Primitive>
void BodyBoxes::update(const Scene& scene, const Options& options, const CycleLimit& limit) {
  received_.resize(scene.bodyCount());
  earlier_received_.resize(scene.bodyCount());
  posed_.resize(scene.bodyCount());
  all_finite_.resize(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const Body& body = scene.body(id);
    const auto posed = [&](const ReceivedBox& received, const RigidTransform& pose) {
      const Aabb box = posedBox(received.box, pose, pose.isIdentity());
      all_finite_[id] =
          all_finite_[id] && received.all_finite && isFinite(box.min) && isFinite(box.max);
      return box.empty() ? box : inflated(box, growthOf<Primitive>(body, options));
    };
    all_finite_[id] = true;
    if (!updateReceived(body.vertices_revision, body.mesh.vertices, limit, received_[id])) return;
    posed_[id].to = posed(received_[id], body.pose);
    if (!kIsMoving<Primitive>) continue;
    posed_[id].from = posed_[id].to;
    if (!body.earlier) continue;
    const HostList<float>& earlier = body.earlier->vertices;
    if (!earlier.empty() &&
        !updateReceived(body.earlier_revision, earlier, limit, earlier_received_[id])) {
      return;
    }
    posed_[id].from =
        posed(earlier.empty() ? received_[id] : earlier_received_[id], body.earlier->pose);
  }
}

// Compares the box of one body with those of all bodies that it may touch.
template <class Primitive>
PartnerBoxes<BoxOf<Primitive>> BodyBoxes::partnersOf(const Scene& scene, BodyId id) const {
  using Box = BoxOf<Primitive>;
  PartnerBoxes<Box> partners;
  partners.self = scene.pairEnabled(id, id);
  const Box& own = boxAs<Box>(posed_[id]);
  for (BodyId other = 0; other < scene.bodyCount(); ++other) {
    if (other == id || !scene.pairEnabled(id, other)) continue;
    const Box& its = boxAs<Box>(posed_[other]);
    if (!intersects(own, its)) continue;
    partners.boxes.push_back(its);
    partners.bound.include(its);
  }
  return partners;
}

// The instantiations are exported here because a template whose arguments are hidden would be
// hidden too.
template DCM_EXPORT void BodyBoxes::update<Triangle>(const Scene&, const Options&,
                                                     const CycleLimit&);
template DCM_EXPORT void BodyBoxes::update<MovingTriangle>(const Scene&, const Options&,
                                                           const CycleLimit&);
template DCM_EXPORT PartnerBoxes<Aabb> BodyBoxes::partnersOf<Triangle>(const Scene&, BodyId) const;
template DCM_EXPORT PartnerBoxes<MovingBox> BodyBoxes::partnersOf<MovingTriangle>(const Scene&,
                                                                                  BodyId) const;

}  // namespace deformable_contact_monitor
