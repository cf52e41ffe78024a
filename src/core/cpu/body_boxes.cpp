#include "core/cpu/body_boxes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/parallel.h"

namespace deformable_contact_monitor {
namespace {

// The box of all vertices; false if some coordinate is not finite, then the box is of no use. Four
// vertices at a time, which is one loop over vectors.
bool boundFinite(const std::vector<float>& xyz, const CycleLimit& limit, Aabb& box) {
  constexpr std::size_t kStep = 12, kBlock = kStep << 15;
  float lo[kStep], hi[kStep], check[kStep] = {};  // check turns NaN with the first that is not
  std::fill_n(lo, kStep, INFINITY);
  std::fill_n(hi, kStep, -INFINITY);
  const std::size_t whole = xyz.size() / kStep * kStep;
  serialBlocks(limit, whole, kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; i += kStep) {
      for (std::size_t k = 0; k < kStep; ++k) {
        const float x = xyz[i + k];
        lo[k] = least(lo[k], x);
        hi[k] = most(hi[k], x);
        check[k] += x - x;
      }
    }
  });
  for (std::size_t i = whole; i < xyz.size(); ++i) {
    const std::size_t k = i % 3;
    lo[k] = least(lo[k], xyz[i]);
    hi[k] = most(hi[k], xyz[i]);
    check[k] += xyz[i] - xyz[i];
  }
  for (std::size_t k = 0; k < kStep; k += 3) {
    box.include(Aabb{{lo[k], lo[k + 1], lo[k + 2]}, {hi[k], hi[k + 1], hi[k + 2]}});
  }
  return std::all_of(check, check + kStep, [](float c) { return c == 0; });
}

Aabb boxOfFiniteVertices(const TriangleMesh& mesh, const CycleLimit& limit) {
  constexpr std::size_t kBlock = 1 << 16;
  Aabb box;
  serialBlocks(limit, mesh.vertexCount(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (isFinite(mesh.vertex(i))) box.include(mesh.vertex(i));
    }
  });
  return box;
}

// A box in the scene frame that holds every posed float32 vertex of a body with this received box;
// infinite where double does not tell.
Aabb posedBox(const Aabb& received, const RigidTransform& pose) {
  if (received.empty() || pose.isIdentity()) return received;
  const double lo[3] = {received.min.x, received.min.y, received.min.z};
  const double hi[3] = {received.max.x, received.max.y, received.max.z};
  float min[3], max[3];
  for (int i = 0; i < 3; ++i) {
    double centre = pose.translation[i], extent = 0, size = std::fabs(pose.translation[i]);
    for (int j = 0; j < 3; ++j) {
      const double r = pose.rotation[3 * i + j];
      centre += r * (lo[j] + hi[j]) / 2;
      extent += std::fabs(r) * (hi[j] - lo[j]) / 2;
      size += std::fabs(r) * std::max(std::fabs(lo[j]), std::fabs(hi[j]));
    }
    // float32 rounding of the vertices (2^-24 of their size) and of the box itself.
    const double reach = extent + size * 2.5e-7 + 1e-44;
    min[i] = static_cast<float>(centre - reach);
    max[i] = static_cast<float>(centre + reach);
    if (std::isnan(min[i]) || std::isnan(max[i])) {  // infinities were subtracted
      min[i] = -INFINITY;
      max[i] = INFINITY;
    }
  }
  return {{min[0], min[1], min[2]}, {max[0], max[1], max[2]}};
}

}  // namespace

void BodyBoxes::update(const Scene& scene, const CycleLimit& limit) {
  received_.resize(scene.bodyCount());
  posed_.resize(scene.bodyCount());
  all_finite_.resize(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const Body& body = scene.body(id);
    ReceivedBox& received = received_[id];
    if (received.vertices_revision != body.vertices_revision) {
      received = {body.vertices_revision, Aabb(), true};
      received.all_finite = boundFinite(body.mesh.vertices, limit, received.box);
      if (!received.all_finite) received.box = boxOfFiniteVertices(body.mesh, limit);
      if (limit.wasOver()) {
        received = ReceivedBox();  // of some vertices alone
        return;
      }
    }
    const Aabb posed = posedBox(received.box, body.pose);
    all_finite_[id] = received.all_finite && isFinite(posed.min) && isFinite(posed.max);
    // Inflated, what is infinite ends at the largest float32.
    posed_[id] = posed.empty() ? posed : inflated(posed, body.margin_m);
  }
}

PartnerBoxes BodyBoxes::partnersOf(const Scene& scene, BodyId id) const {
  PartnerBoxes partners;
  partners.self = scene.pairEnabled(id, id);
  for (BodyId other = 0; other < scene.bodyCount(); ++other) {
    if (other == id || !scene.pairEnabled(id, other)) continue;
    if (!intersects(posed_[id], posed_[other])) continue;
    partners.boxes.push_back(posed_[other]);
    partners.hull.include(posed_[other]);
  }
  return partners;
}

}  // namespace deformable_contact_monitor
