#include <algorithm>
#include <string>

#include "core/common/part_table.h"
#include "cuda/device/cuda_error.h"
#include "cuda/device/warp.cuh"
#include "cuda/memory/scene_tables.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kBlock = 128;
// Limits the scene: places of tile entries have 29 bits, and a triangle may have several entries.
constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 27;

void addBlocks(SceneTables::List<BodyBlock>& blocks, BodyIndex body, std::uint32_t first,
               std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; i += kBlock) {
    blocks.push_back({body, first + i, std::min(kBlock, count - i)});
  }
}

}  // namespace

SceneTables::SceneTables(const Scene& scene) {
  for (BodyId a = 0; a < scene.bodyCount(); ++a) {
    if (scene.takesPart(a)) taking_part.push_back(a);
  }
  makeRoom(scene);
  const BodyGroups groups(scene);
  group_count = static_cast<std::uint32_t>(groups.enabled.size());
  const auto count = static_cast<std::uint32_t>(taking_part.size());
  group_mask.resize(kMostGroups);
  addParts(scene);
  for (std::uint32_t i = 0; i < count; ++i) {
    addPairs(scene, groups, BodyIndex(i));
    addMesh(scene.body(taking_part[i]).mesh, BodyIndex(i));
  }
}

void SceneTables::addPairs(const Scene& scene, const BodyGroups& groups, BodyIndex row) {
  const auto groupOf = [&](BodyId a) { return std::min(groups.group[a], kMostGroups - 1); };
  const BodyId a = taking_part[row.value];
  DeviceBody body{};
  body.has_self = scene.pairEnabled(a, a) ? 1 : 0;
  any_self = any_self || body.has_self != 0;
  const TriangleMesh& mesh = scene.body(a).mesh;
  const bool is_soup = mesh.vertexCount() >= 3 * mesh.triangleCount();
  any_self_mesh = any_self_mesh || (body.has_self != 0 && !is_soup);
  if (body.has_self != 0) self_vertices += static_cast<std::uint32_t>(mesh.vertexCount());
  body.group = groupOf(a);
  body.partner_begin = static_cast<std::uint32_t>(partners.size());
  for (std::uint32_t j = 0; j < taking_part.size(); ++j) {
    const BodyId b = taking_part[j];
    if (!scene.pairEnabled(a, b)) continue;
    if (a != b) partners.push_back(BodyIndex(j));
    group_mask[groupOf(a)] |= 1U << groupOf(b);
  }
  body.partner_count = static_cast<std::uint32_t>(partners.size()) - body.partner_begin;
  bodies.push_back(body);
}

// Sets which pairs of parts are enabled and, if some body has parts, the part of each triangle.
void SceneTables::addParts(const Scene& scene) {
  const PartTable table(scene);
  pair_row = table.pairs().row_words;
  pair_enabled.assign(table.bits().begin(), table.bits().end());
  part_use.matter = scene.partsMatter();
  part_use.any =
      part_use.matter || std::any_of(taking_part.begin(), taking_part.end(),
                                     [&scene](BodyId id) { return !scene.body(id).parts.empty(); });
  if (!part_use.any) return;
  for (const BodyId id : taking_part) {
    const Body& body = scene.body(id);
    for (const PartId its : body.listed_parts) parts.emplace_back(id, its);
    for (std::size_t t = 0; t < body.mesh.triangleCount(); ++t) {
      const std::uint32_t number = table.of(id, t);
      part.push_back(table.takesPart(number) ? number : kNone);
    }
  }
}

// Reserves room for all lists, because growing them step by step would allocate page-locked memory
// several times. Throws CudaError if the scene is too large.
void SceneTables::makeRoom(const Scene& scene) {
  std::uint64_t vertices = 0, triangles = 0;
  for (const BodyId id : taking_part) {
    vertices += scene.body(id).mesh.vertexCount();
    triangles += scene.body(id).mesh.triangleCount();
  }
  if (triangles > kMostTriangles || vertices > kMostTriangles) {
    throw CudaError(BackendFault::kSceneTooLarge, "the scene has " + std::to_string(triangles) +
                                                      " triangles and " + std::to_string(vertices) +
                                                      " vertices; the CUDA backend takes up to " +
                                                      std::to_string(kMostTriangles) + " of each");
  }
  const std::size_t bodies_here = taking_part.size();
  bodies.reserve(bodies_here);
  listed.reserve(bodies_here);
  vertex_blocks.reserve(vertices / kBlock + bodies_here);
  triangle_blocks.reserve(triangles / kBlock + bodies_here);
}

void SceneTables::addMesh(const TriangleMesh& mesh, BodyIndex number) {
  listed.push_back({triangle_count, taking_part[number.value]});
  DeviceBody& body = bodies[number.value];
  body.first_vertex = vertex_count;
  body.vertex_count = static_cast<std::uint32_t>(mesh.vertexCount());
  body.first_triangle = triangle_count;
  body.triangle_count = static_cast<std::uint32_t>(mesh.triangleCount());
  body.first_tile = tile_count;
  addBlocks(vertex_blocks, number, vertex_count, body.vertex_count);
  addBlocks(triangle_blocks, number, triangle_count, body.triangle_count);
  vertex_count += body.vertex_count;
  triangle_count += body.triangle_count;
  tile_count += (body.triangle_count + kWarp - 1) / kWarp;
}

}  // namespace deformable_contact_monitor
