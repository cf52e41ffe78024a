#include "core/cpu/pose.h"

#include <algorithm>
#include <numeric>

#include "core/parallel.h"

namespace deformable_contact_monitor {
namespace {

Vec3f vertexAt(const TriangleMesh& mesh, std::size_t i) {
  return {mesh.vertices[3 * i], mesh.vertices[3 * i + 1], mesh.vertices[3 * i + 2]};
}

// The box of all vertices; false if some coordinate is not finite, then the box is of no use. Four
// vertices at a time, which is one loop over vectors.
bool boundFinite(const std::vector<float>& xyz, Aabb& box) {
  constexpr std::size_t kStep = 12;
  float lo[kStep], hi[kStep], check[kStep] = {};  // check turns NaN with the first that is not
  std::fill_n(lo, kStep, INFINITY);
  std::fill_n(hi, kStep, -INFINITY);
  std::size_t i = 0;
  for (; i + kStep <= xyz.size(); i += kStep) {
    for (std::size_t k = 0; k < kStep; ++k) {
      const float x = xyz[i + k];
      lo[k] = least(lo[k], x);
      hi[k] = most(hi[k], x);
      check[k] += x - x;
    }
  }
  for (; i < xyz.size(); ++i) {
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

// A box in the scene frame that holds every posed float32 vertex of a body with this local box.
Aabb posedBox(const Aabb& local, const RigidTransform& pose, float margin_m) {
  if (local.empty()) return local;
  if (pose.isIdentity()) return inflated(local, margin_m);
  const double lo[3] = {local.min.x, local.min.y, local.min.z};
  const double hi[3] = {local.max.x, local.max.y, local.max.z};
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
  }
  return inflated({{min[0], min[1], min[2]}, {max[0], max[1], max[2]}}, margin_m);
}

bool cornersFinite(const TriangleMesh& mesh, std::size_t t) {
  for (int k = 0; k < 3; ++k) {
    if (!isFinite(vertexAt(mesh, mesh.triangles[3 * t + k]))) return false;
  }
  return true;
}

// The boxes of a body's partners, clipped to where the body is.
struct Partners {
  bool self = false;
  Aabb hull;
  std::vector<Aabb> boxes;

  bool meets(const Aabb& box) const {
    if (self) return true;
    return overlap(hull, box) && std::any_of(boxes.begin(), boxes.end(),
                                             [&box](const Aabb& p) { return overlap(p, box); });
  }
};

Partners partnersOf(const Scene& scene, BodyId a, const std::vector<Aabb>& boxes) {
  Partners partners;
  partners.self = scene.pairEnabled(a, a);
  for (BodyId b = 0; b < scene.bodyCount(); ++b) {
    if (b == a || !scene.pairEnabled(a, b) || !overlap(boxes[a], boxes[b])) continue;
    partners.boxes.push_back(boxes[b]);
    partners.hull.include(boxes[b]);
  }
  return partners;
}

// What one block of a body's triangles contributes.
struct Block {
  std::vector<std::uint32_t> triangle;
  std::vector<Aabb> boxes;
  std::uint64_t rejected = 0;
};

}  // namespace

void WorkingSetBuilder::updateLocalBoxes(const Scene& scene) {
  local_boxes_.resize(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const Body& body = scene.body(id);
    LocalBox& local = local_boxes_[id];
    if (!scene.takesPart(id)) continue;
    if (local.vertices_revision == body.vertices_revision) continue;
    local = {body.vertices_revision, Aabb(), true};
    local.all_finite = boundFinite(body.mesh.vertices, local.box);
    if (local.all_finite) continue;
    local.box = Aabb();
    for (std::size_t i = 0; i < body.mesh.vertexCount(); ++i) {
      if (isFinite(vertexAt(body.mesh, i))) local.box.include(vertexAt(body.mesh, i));
    }
  }
}

void WorkingSetBuilder::poseBody(const Body& body, std::uint32_t first,
                                 std::vector<Vec3f>& vertices) const {
  constexpr std::size_t kBlock = 16384;
  const bool identity = body.pose.isIdentity();
  parallelBlocks(body.mesh.vertexCount(), kBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t i = begin; i < end; ++i) {
                     const Vec3f v = vertexAt(body.mesh, i);
                     vertices[first + i] = identity ? v : apply(body.pose, v);
                   }
                 });
}

// Only a body's own triangles ask which vertices they share.
void WorkingSetBuilder::identifyVertices(const Body& body, bool self, std::uint32_t first,
                                         WorkingSet& set) {
  if (!self) {
    std::iota(set.vertex_id.begin() + first, set.vertex_id.end(), first);
    return;
  }
  identity_.identify(body.mesh.vertices, least_equal_);
  for (std::size_t i = 0; i < least_equal_.size(); ++i) {
    set.vertex_id[first + i] = first + least_equal_[i];
  }
}

void WorkingSetBuilder::build(const Scene& scene, WorkingSet& set, Counters& counters) {
  updateLocalBoxes(scene);
  const std::size_t body_count = scene.bodyCount();
  std::vector<Aabb> boxes(body_count);
  for (BodyId id = 0; id < body_count; ++id) {
    const Body& body = scene.body(id);
    boxes[id] = posedBox(local_boxes_[id].box, body.pose, body.margin_m);
  }
  set.corners.clear();
  set.body.clear();
  set.triangle.clear();
  set.boxes.clear();
  set.vertices.clear();
  set.vertex_id.clear();
  set.first_vertex.assign(body_count, 0);
  counters.triangles = scene.triangleCount();
  for (BodyId id = 0; id < body_count; ++id) {
    const Body& body = scene.body(id);
    const TriangleMesh& mesh = body.mesh;
    if (!scene.takesPart(id)) continue;
    const Partners partners = partnersOf(scene, id, boxes);
    if (!partners.self && partners.boxes.empty()) {
      std::uint64_t rejected = 0;
      if (!local_boxes_[id].all_finite) {
        for (std::size_t t = 0; t < mesh.triangleCount(); ++t) rejected += !cornersFinite(mesh, t);
      }
      counters.rejected += rejected;
      counters.culled += mesh.triangleCount() - rejected;
      continue;
    }
    const auto first = static_cast<std::uint32_t>(set.vertices.size());
    set.first_vertex[id] = first;
    set.vertices.resize(first + mesh.vertexCount());
    poseBody(body, first, set.vertices);
    set.vertex_id.resize(set.vertices.size());
    identifyVertices(body, partners.self, first, set);
    counters.posed += mesh.triangleCount();

    constexpr std::size_t kBlock = 8192;
    std::vector<Block> blocks(blockCount(mesh.triangleCount(), kBlock));
    parallelBlocks(
        mesh.triangleCount(), kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
          Block& block = blocks[b];
          block.triangle.reserve(end - begin);
          block.boxes.reserve(end - begin);
          for (std::size_t t = begin; t < end; ++t) {
            const std::uint32_t* corner = &mesh.triangles[3 * t];
            const Triangle posed{{set.vertices[first + corner[0]], set.vertices[first + corner[1]],
                                  set.vertices[first + corner[2]]}};
            if (!isFinite(posed.v[0]) || !isFinite(posed.v[1]) || !isFinite(posed.v[2])) {
              ++block.rejected;
              continue;
            }
            const Aabb box = inflated(boxOf(posed), body.margin_m);
            if (!partners.meets(box)) continue;
            block.triangle.push_back(static_cast<std::uint32_t>(t));
            block.boxes.push_back(box);
          }
        });
    std::size_t kept = 0, rejected = 0;
    for (const Block& block : blocks) {
      set.triangle.insert(set.triangle.end(), block.triangle.begin(), block.triangle.end());
      set.boxes.insert(set.boxes.end(), block.boxes.begin(), block.boxes.end());
      kept += block.triangle.size();
      rejected += block.rejected;
    }
    set.body.insert(set.body.end(), kept, id);
    counters.rejected += rejected;
    counters.culled += mesh.triangleCount() - kept - rejected;
  }
  const std::size_t count = set.triangle.size();
  set.corners.resize(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t* corner =
        &scene.body(set.body[i]).mesh.triangles[3 * std::size_t{set.triangle[i]}];
    const std::uint32_t first = set.first_vertex[set.body[i]];
    for (int k = 0; k < 3; ++k) set.corners[3 * i + k] = first + corner[k];
  }
}

}  // namespace deformable_contact_monitor
