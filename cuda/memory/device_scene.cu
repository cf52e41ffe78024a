#include <algorithm>
#include <cstring>
#include <string>

#include "core/rules/margins.h"
#include "cuda/memory/device_scene.cuh"
#include "cuda/memory/pinned_memory.cuh"
#include "cuda/stages/fan_rings.cuh"
#include "cuda/stages/group.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kBlock = 128;
// Places of members are kept in 29 bits; a triangle may have several.
constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 27;

void addBlocks(std::vector<BodyBlock>& blocks, BodyIndex body, std::uint32_t first,
               std::size_t count) {
  for (std::size_t i = 0; i < count; i += kBlock) {
    blocks.push_back({body, first + static_cast<std::uint32_t>(i),
                      static_cast<std::uint32_t>(std::min<std::size_t>(kBlock, count - i))});
  }
}

// Behind what is in the stream. `from` may go once the stream has been waited for.
template <class T>
void upload(const T* from, std::size_t count, void* to, cudaStream_t stream) {
  if (count == 0) return;
  checkCuda(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyHostToDevice, stream),
            "cudaMemcpyAsync to the device");
}

template <class T>
void upload(const std::vector<T>& from, T* to, cudaStream_t stream) {
  upload(from.data(), from.size(), to, stream);
}

// Vertices of a body whose first coordinate is `first` of all, by way of `staged` where they are
// not in page-locked memory.
template <class List>
void send(const List& vertices, std::size_t first, std::size_t all, PinnedBuffer<float>& staged,
          float* to, cudaStream_t stream) {
  const float* from = vertices.data();
  if (!isPinned(from)) {
    staged.grow(all);  // once for all of them, or it would go while it is in use
    std::copy(vertices.begin(), vertices.end(), staged.data() + first);
    from = staged.data() + first;
  }
  upload(from, vertices.size(), to + first, stream);
}

}  // namespace

std::vector<DeviceScene::LaidOutBody> DeviceScene::bodiesOf(const Scene& scene) const {
  std::vector<LaidOutBody> bodies;
  bodies.reserve(taking_part_.size());
  for (const BodyId id : taking_part_) {
    const Body& body = scene.body(id);
    bodies.push_back(
        {id, body.topology_revision, static_cast<std::uint32_t>(body.mesh.triangleCount())});
  }
  return bodies;
}

// Pairs that were switched off and on again are the same ones.
bool DeviceScene::isLaidOut(const Scene& scene) const {
  if (!laid_out_) return false;
  if (pairs_revision_ != scene.pairsRevision() && pairs_ != scene.enabledPairs()) return false;
  return laid_out_bodies_ == bodiesOf(scene);
}

DeviceScene::Change DeviceScene::layOut(const Scene& scene, Motion motion, bool fans) {
  sizes_.swept = motion == Motion::kSwept;
  Change change;
  if (!isLaidOut(scene)) change = layOutAnew(scene);
  pairs_revision_ = scene.pairsRevision();
  if (fans && any_self_ && !has_fans_) sizeFans(scene);
  sizes_.follow();
  any_from_device_ = std::any_of(taking_part_.begin(), taking_part_.end(), [&](BodyId id) {
    return scene.body(id).device_vertices.has_value();
  });
  return change;
}

// Both in the order of their bodies.
std::uint64_t DeviceScene::moreTriangles(const std::vector<LaidOutBody>& before,
                                         const std::vector<LaidOutBody>& now) {
  std::uint64_t more = 0;
  auto old = before.begin();
  for (const LaidOutBody& body : now) {
    while (old != before.end() && old->id < body.id) ++old;
    const std::uint32_t had = old != before.end() && old->id == body.id ? old->triangles : 0;
    more += body.triangles > had ? body.triangles - had : 0;
  }
  return more;
}

DeviceScene::Change DeviceScene::layOutAnew(const Scene& scene) {
  const std::vector<LaidOutBody> before = laid_out_ ? laid_out_bodies_ : std::vector<LaidOutBody>();
  laid_out_ = has_fans_ = bodies_sent_ = false;  // until all of it is there
  pairs_ = scene.enabledPairs();
  pair_tables_ = tabulatePairs(scene);
  laid_out_bodies_ = bodiesOf(scene);
  const auto same =
      std::mismatch(laid_out_bodies_.begin(), laid_out_bodies_.end(), before.begin(), before.end());
  const auto first = static_cast<std::uint32_t>(same.first - laid_out_bodies_.begin());
  grouped_ = std::min(grouped_, first);
  countMeshes(scene);
  numberMeshes(scene);
  mesh_tables_ = tabulateMeshes(scene, first);
  CycleSizes::raise(sizes_.bodies, body_.size());
  CycleSizes::raise(sizes_.partners, pair_tables_.partners.size());
  CycleSizes::raise(sizes_.pair_words, pair_tables_.pair_enabled.size());
  CycleSizes::raise(sizes_.vertices, vertex_count_);
  CycleSizes::raise(sizes_.triangles, arrays_.triangle_count);
  CycleSizes::raise(sizes_.vertex_blocks, mesh_tables_.vertex_blocks.size());
  CycleSizes::raise(sizes_.triangle_blocks, mesh_tables_.triangle_blocks.size());
  CycleSizes::raise(sizes_.tiles, arrays_.tile_count);
  sizes_.slots = kWarp * sizes_.tiles;
  sizes_.identity_slots = 16;  // a power of two, as is what it may have been before
  while (any_self_ && sizes_.identity_slots < 2 * vertex_count_) sizes_.identity_slots *= 2;
  vertices_.resize(scene.bodyCount());
  earlier_.resize(scene.bodyCount());
  for (std::uint32_t i = first; i < taking_part_.size(); ++i) {
    vertices_[taking_part_[i]] = earlier_[taking_part_[i]] = 0;  // no revision is 0
  }
  return {true, moreTriangles(before, laid_out_bodies_)};
}

void DeviceScene::addPairs(const Scene& scene, const BodyGroups& groups, BodyIndex row,
                           PairTables& tables) {
  const auto groupOf = [&](BodyId a) { return std::min(groups.group[a], kMostGroups - 1); };
  const BodyId a = taking_part_[row.value];
  DeviceBody body{};
  body.has_self = scene.pairEnabled(a, a) ? 1 : 0;
  any_self_ = any_self_ || body.has_self != 0;
  body.group = groupOf(a);
  body.partner_begin = static_cast<std::uint32_t>(tables.partners.size());
  for (std::uint32_t j = 0; j < taking_part_.size(); ++j) {
    const BodyId b = taking_part_[j];
    if (!scene.pairEnabled(a, b)) continue;
    if (a != b) tables.partners.push_back(BodyIndex(j));
    tables.group_mask[groupOf(a)] |= 1U << groupOf(b);
    tables.pair_enabled[row.value * arrays_.pair_row + j / 32] |= 1U << j % 32;
  }
  body.partner_count = static_cast<std::uint32_t>(tables.partners.size()) - body.partner_begin;
  body_.push_back(body);
}

DeviceScene::PairTables DeviceScene::tabulatePairs(const Scene& scene) {
  taking_part_.clear();
  body_.clear();
  any_self_ = false;
  for (BodyId a = 0; a < scene.bodyCount(); ++a) {
    if (scene.takesPart(a)) taking_part_.push_back(a);
  }
  const BodyGroups groups(scene);
  group_count_ = static_cast<std::uint32_t>(groups.enabled.size());
  arrays_.body_count = static_cast<std::uint32_t>(taking_part_.size());
  arrays_.pair_row = (arrays_.body_count + 31) / 32;
  PairTables tables;
  tables.group_mask.resize(kMostGroups);
  tables.pair_enabled.resize(std::size_t{arrays_.body_count} * arrays_.pair_row);
  for (std::uint32_t i = 0; i < arrays_.body_count; ++i) {
    addPairs(scene, groups, BodyIndex(i), tables);
  }
  return tables;
}

void DeviceScene::sendLayout(cudaStream_t stream) {
  growArrays(stream);
  if (laid_out_) return;
  const MeshTables& meshes = mesh_tables_;
  arrays_.vertex_block_count = static_cast<std::uint32_t>(meshes.vertex_blocks.size());
  arrays_.triangle_block_count = static_cast<std::uint32_t>(meshes.triangle_blocks.size());
  arrays_.identity_mask = arrays_.identity_table.size() - 1;
  upload(pair_tables_.partners, arrays_.partners.data(), stream);
  upload(pair_tables_.group_mask, arrays_.group_mask.data(), stream);
  upload(pair_tables_.pair_enabled, arrays_.pair_enabled.data(), stream);
  upload(listed_, arrays_.listed_bodies.data(), stream);
  upload(meshes.vertex_blocks, arrays_.vertex_blocks.data(), stream);
  upload(meshes.triangle_blocks, arrays_.triangle_blocks.data(), stream);
  upload(meshes.corners.get(), meshes.corner_count,
         arrays_.corners.data() + 3 * std::size_t{meshes.first_triangle}, stream);
  checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  pair_tables_ = PairTables();
  mesh_tables_ = MeshTables();
  laid_out_ = true;
}

// What small things are sent through has room for as many as the device.
void DeviceScene::growArrays(cudaStream_t stream) {
  memory_.grow(sizes_, stream);
  staged_bodies_.grow(sizes_.bodies);
  if (sizes_.swept) staged_earlier_bodies_.grow(sizes_.bodies);
}

void DeviceScene::countMeshes(const Scene& scene) {
  std::uint64_t vertices = 0, triangles = 0;
  for (const BodyId id : taking_part_) {
    vertices += scene.body(id).mesh.vertexCount();
    triangles += scene.body(id).mesh.triangleCount();
  }
  if (triangles > kMostTriangles || vertices > kMostTriangles) {
    throw CudaError(BackendFault::kSceneTooLarge, "the scene has " + std::to_string(triangles) +
                                                      " triangles and " + std::to_string(vertices) +
                                                      " vertices; the CUDA backend takes up to " +
                                                      std::to_string(kMostTriangles) + " of each");
  }
  vertex_count_ = static_cast<std::uint32_t>(vertices);
  arrays_.triangle_count = static_cast<std::uint32_t>(triangles);
}

void DeviceScene::numberMeshes(const Scene& scene) {
  listed_.clear();
  std::uint32_t first_vertex = 0, first_triangle = 0, first_tile = 0;
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const TriangleMesh& mesh = scene.body(taking_part_[i]).mesh;
    listed_.push_back({first_triangle, taking_part_[i]});
    DeviceBody& body = body_[i];
    body.first_vertex = first_vertex;
    body.vertex_count = static_cast<std::uint32_t>(mesh.vertexCount());
    body.first_triangle = first_triangle;
    body.triangle_count = static_cast<std::uint32_t>(mesh.triangleCount());
    body.first_tile = first_tile;
    first_vertex += body.vertex_count;
    first_triangle += body.triangle_count;
    first_tile += (body.triangle_count + kWarp - 1) / kWarp;
  }
  arrays_.tile_count = first_tile;
}

DeviceScene::MeshTables DeviceScene::tabulateMeshes(const Scene& scene,
                                                    std::uint32_t first_body) const {
  MeshTables tables;
  tables.first_triangle = first_body < taking_part_.size() ? listed_[first_body].first_triangle : 0;
  const std::uint32_t changed =
      first_body < taking_part_.size() ? arrays_.triangle_count - tables.first_triangle : 0;
  tables.corner_count = 3 * std::size_t{changed};
  tables.corners.reset(new VertexIndex[tables.corner_count]);
  VertexIndex* corner = tables.corners.get();
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const TriangleMesh& mesh = scene.body(taking_part_[i]).mesh;
    const std::uint32_t first_vertex = body_[i].first_vertex;
    addBlocks(tables.vertex_blocks, BodyIndex(i), first_vertex, mesh.vertexCount());
    addBlocks(tables.triangle_blocks, BodyIndex(i), listed_[i].first_triangle,
              mesh.triangleCount());
    if (i < first_body) continue;
    for (const std::uint32_t local : mesh.triangles) *corner++ = VertexIndex(first_vertex + local);
  }
  return tables;
}

void DeviceScene::group(cudaStream_t stream) {
  if (grouped_ >= body_.size()) return;
  const DeviceBody& first = body_[grouped_];
  UngroupedBodies bodies{BodyIndex(grouped_), first.first_triangle, first.first_tile, 0};
  for (std::size_t i = grouped_; i < body_.size(); ++i) {
    bodies.most_triangles = std::max(bodies.most_triangles, body_[i].triangle_count);
  }
  launchGroup(arrays_, bodies, scratch_, stream);
  if (grouped_ == 0) deformed_ = 0;
  grouped_ = arrays_.body_count;
}

void DeviceScene::groupAgain(cudaStream_t stream) {
  if (deformed_ < kGroupedFor) return;
  grouped_ = 0;
  group(stream);
}

// Vertices of bodies without contacts with themselves have no ring.
void DeviceScene::sizeFans(const Scene& scene) {
  std::uint64_t places = 0;
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    if (body_[i].has_self == 0) continue;
    const TriangleMesh& mesh = scene.body(taking_part_[i]).mesh;
    places += mesh.vertexCount() + mesh.triangles.size();
  }
  CycleSizes::raise(sizes_.fan_vertices, std::uint64_t{vertex_count_} + 1);
  CycleSizes::raise(sizes_.fan_places, places);
}

void DeviceScene::findFans(cudaStream_t stream) {
  if (has_fans_) return;
  launchFanRings(arrays_, vertex_count_, scratch_, stream);
  has_fans_ = true;
}

void DeviceScene::sendVertices(const Scene& scene, Motion motion, cudaStream_t stream) {
  for (const BodyId id : taking_part_) {
    const Body& from = scene.body(id);
    if (!from.device_vertices) continue;
    if (vertices_[id] != from.vertices_revision) requireReadable(from, device_);
  }
  bool any = false;
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const BodyId id = taking_part_[i];
    const Body& from = scene.body(id);
    if (vertices_[id] == from.vertices_revision) continue;
    any = true;
    const std::size_t first = 3 * std::size_t{body_[i].first_vertex};
    if (from.device_vertices) {
      copier_.copy(from, arrays_.received.data() + first, stream);
    } else {
      send(from.mesh.vertices, first, 3 * std::size_t{sizes_.vertices}, staged_vertices_,
           arrays_.received.data(), stream);
    }
    vertices_[id] = from.vertices_revision;
  }
  deformed_ += any ? 1 : 0;
  if (motion == Motion::kSwept) sendEarlierVertices(scene, stream);
}

void DeviceScene::sendEarlierVertices(const Scene& scene, cudaStream_t stream) {
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const BodyId id = taking_part_[i];
    const Body& from = scene.body(id);
    if (!from.earlier || from.earlier->vertices.empty()) continue;
    if (earlier_[id] == from.earlier_revision) continue;
    const std::size_t first = 3 * std::size_t{body_[i].first_vertex};
    send(from.earlier->vertices, first, 3 * std::size_t{sizes_.vertices}, staged_earlier_vertices_,
         arrays_.earlier_received.data(), stream);
    earlier_[id] = from.earlier_revision;
  }
}

Scene DeviceScene::onHost(const Scene& scene, cudaStream_t stream) const {
  Scene on_host = scene;
  std::vector<float> xyz;
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const BodyId id = taking_part_[i];
    if (!scene.body(id).device_vertices) continue;
    const std::size_t count = body_[i].vertex_count;
    xyz.resize(3 * count);
    checkCuda(cudaMemcpyAsync(xyz.data(),
                              arrays_.received.data() + 3 * std::size_t{body_[i].first_vertex},
                              xyz.size() * sizeof(float), cudaMemcpyDeviceToHost, stream),
              "cudaMemcpyAsync to the host");
    checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
    on_host.setVertices(id, xyz.data(), count);
  }
  return on_host;
}

void DeviceScene::sendBodies(const Scene& scene, Motion motion, const SceneScale& scale,
                             cudaStream_t stream) {
  const bool swept = motion == Motion::kSwept;
  any_ = {scene.anyMargin(), scene.anyPad()};
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const Body& from = scene.body(taking_part_[i]);
    DeviceBody& body = body_[i];
    body.pose = from.pose;
    body.identity_pose = from.pose.isIdentity() ? 1 : 0;
    body.margin_m = swept ? grownPad(from.pad_m) : from.margin_m;
    body.slack = scaledSlack(body.margin_m, scale);
    bodies_sent_ = bodies_sent_ && std::memcmp(&staged_bodies_[i], &body, sizeof body) == 0;
    staged_bodies_[i] = body;
  }
  if (!bodies_sent_) upload(staged_bodies_.data(), body_.size(), arrays_.bodies.data(), stream);
  bodies_sent_ = true;
  if (swept) sendEarlierBodies(scene, stream);
}

void DeviceScene::sendEarlierBodies(const Scene& scene, cudaStream_t stream) {
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const Body& from = scene.body(taking_part_[i]);
    EarlierBody& body = staged_earlier_bodies_[i];
    body.pose = from.earlier ? from.earlier->pose : from.pose;
    body.identity_pose = body.pose.isIdentity() ? 1 : 0;
    body.is_still = from.earlier ? 0 : 1;
    body.has_vertices = from.earlier && !from.earlier->vertices.empty() ? 1 : 0;
    body.pad_m = from.pad_m;
  }
  upload(staged_earlier_bodies_.data(), body_.size(), arrays_.earlier_bodies.data(), stream);
}

}  // namespace deformable_contact_monitor
