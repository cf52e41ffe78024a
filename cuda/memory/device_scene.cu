#include <algorithm>
#include <cstring>

#include "core/body_groups.h"
#include "cuda/device/boxes.cuh"
#include "cuda/memory/device_scene.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kBlock = 128;
// Places of members are kept in 29 bits; a triangle may have several.
constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 27;

void addBlocks(std::vector<BodyBlock>& blocks, std::uint32_t body, std::uint32_t first,
               std::size_t count) {
  for (std::size_t i = 0; i < count; i += kBlock) {
    blocks.push_back({body, first + static_cast<std::uint32_t>(i),
                      static_cast<std::uint32_t>(std::min<std::size_t>(kBlock, count - i))});
  }
}

// For what changes rarely; waits until `from` may go.
template <class T>
void put(DeviceBuffer<T>& to, const std::vector<T>& from, cudaStream_t stream) {
  to.grow(std::max<std::size_t>(1, from.size()));
  to.upload(from.data(), from.size(), stream);
  checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
}

}  // namespace

bool DeviceScene::layOut(const Scene& scene, cudaStream_t stream) {
  std::vector<std::uint64_t> topology;
  topology.reserve(scene.bodyCount());
  for (const Body& body : scene.bodies()) topology.push_back(body.topology_revision);
  if (pairs_revision_ == scene.pairsRevision() && topology == topology_) return false;
  pairs_revision_ = 0;  // until all of it is there
  layOutPairs(scene, stream);
  layOutMeshes(scene, stream);
  topology_ = std::move(topology);
  pairs_revision_ = scene.pairsRevision();
  return true;
}

void DeviceScene::layOutPairs(const Scene& scene, cudaStream_t stream) {
  const auto count = static_cast<BodyId>(scene.bodyCount());
  taking_part_.clear();
  body_.clear();
  any_self_ = false;
  for (BodyId a = 0; a < count; ++a) {
    if (scene.takesPart(a)) taking_part_.push_back(a);
  }
  const BodyGroups groups(scene);
  const auto group_count = static_cast<std::uint32_t>(groups.enabled.size());
  const auto classOf = [&](BodyId a) { return std::min(groups.group[a], kMostClasses - 1); };
  class_count_ = std::min(group_count, kMostClasses);
  classes_exact_ = group_count <= kMostClasses;
  std::vector<std::uint32_t> class_mask(kMostClasses), partners;
  pair_row_ = (static_cast<std::uint32_t>(taking_part_.size()) + 31) / 32;
  std::vector<std::uint32_t> pair_enabled(taking_part_.size() * pair_row_);
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const BodyId a = taking_part_[i];
    DeviceBody body{};
    body.has_self = scene.pairEnabled(a, a) ? 1 : 0;
    any_self_ = any_self_ || body.has_self != 0;
    body.class_of_body = classOf(a);
    body.partner_begin = static_cast<std::uint32_t>(partners.size());
    for (std::uint32_t j = 0; j < taking_part_.size(); ++j) {
      const BodyId b = taking_part_[j];
      if (!scene.pairEnabled(a, b)) continue;
      if (a != b) partners.push_back(j);
      class_mask[classOf(a)] |= 1U << classOf(b);
      pair_enabled[i * pair_row_ + j / 32] |= 1U << j % 32;
    }
    body.partner_count = static_cast<std::uint32_t>(partners.size()) - body.partner_begin;
    body_.push_back(body);
  }
  put(partners_, partners, stream);
  put(class_mask_, class_mask, stream);
  put(pair_enabled_, pair_enabled, stream);
}

void DeviceScene::layOutMeshes(const Scene& scene, cudaStream_t stream) {
  std::uint64_t vertices = 0, triangles = 0;
  for (const BodyId id : taking_part_) {
    vertices += scene.body(id).mesh.vertexCount();
    triangles += scene.body(id).mesh.triangleCount();
  }
  if (triangles > kMostTriangles || vertices > kMostTriangles) {
    throw CudaError("the scene has " + std::to_string(triangles) + " triangles and " +
                    std::to_string(vertices) + " vertices; the CUDA backend takes up to " +
                    std::to_string(kMostTriangles) + " of each");
  }
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * triangles);
  std::vector<BodyBlock> vertex_blocks, triangle_blocks;
  first_triangle_.assign(scene.bodyCount(), 0);
  body_of_.clear();
  body_of_.reserve(triangles);
  vertex_count_ = triangle_count_ = 0;
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const TriangleMesh& mesh = scene.body(taking_part_[i]).mesh;
    addBlocks(vertex_blocks, i, vertex_count_, mesh.vertexCount());
    addBlocks(triangle_blocks, i, triangle_count_, mesh.triangleCount());
    for (const std::uint32_t corner : mesh.triangles) corners.push_back(vertex_count_ + corner);
    first_triangle_[taking_part_[i]] = triangle_count_;
    body_of_.insert(body_of_.end(), mesh.triangleCount(), taking_part_[i]);
    body_[i].first_vertex = vertex_count_;
    body_[i].vertex_count = static_cast<std::uint32_t>(mesh.vertexCount());
    vertex_count_ += body_[i].vertex_count;
    triangle_count_ += static_cast<std::uint32_t>(mesh.triangleCount());
  }
  vertex_block_count_ = static_cast<std::uint32_t>(vertex_blocks.size());
  triangle_block_count_ = static_cast<std::uint32_t>(triangle_blocks.size());
  put(corners_, corners, stream);
  put(vertex_blocks_, vertex_blocks, stream);
  put(triangle_blocks_, triangle_blocks, stream);
  vertices_.assign(scene.bodyCount(), 0);  // no revision is 0
  received_.grow(3 * std::size_t{vertex_count_});
  staged_vertices_.grow(3 * std::size_t{vertex_count_});
  posed_.grow(vertex_count_);
  vertex_id_.grow(vertex_count_);
  far_vertices_.grow(vertex_count_);
  far_count_.grow(1);
  std::size_t table = 16;  // a power of two, as is what it may have been before
  while (any_self_ && table < 2 * std::size_t{vertex_count_}) table *= 2;
  identity_table_.grow(table);
  body_boxes_.grow(kSides * taking_part_.size());
  bodies_.grow(body_.size());
  staged_bodies_.grow(body_.size());
}

void DeviceScene::send(const Scene& scene, const SceneScale& scale, cudaStream_t stream) {
  any_margin_ = false;
  for (std::uint32_t i = 0; i < taking_part_.size(); ++i) {
    const BodyId id = taking_part_[i];
    const Body& from = scene.body(id);
    DeviceBody& body = body_[i];
    body.pose = from.pose;
    body.identity_pose = from.pose.isIdentity() ? 1 : 0;
    body.margin_m = from.margin_m;
    body.slack = scaledSlack(from.margin_m, scale);
    any_margin_ = any_margin_ || from.margin_m > 0;
    staged_bodies_[i] = body;
    if (vertices_[id] == from.vertices_revision) continue;
    const std::size_t first = 3 * std::size_t{body.first_vertex};
    std::memcpy(staged_vertices_.data() + first, from.mesh.vertices.data(),
                from.mesh.vertices.size() * sizeof(float));
    received_.upload(staged_vertices_.data() + first, from.mesh.vertices.size(), stream, first);
    vertices_[id] = from.vertices_revision;
  }
  bodies_.upload(staged_bodies_.data(), body_.size(), stream);
}

void DeviceScene::view(CycleView& cycle) {
  cycle.bodies = bodies_.data();
  cycle.partners = partners_.data();
  cycle.class_mask = class_mask_.data();
  cycle.pair_enabled = pair_enabled_.data();
  cycle.body_count = static_cast<std::uint32_t>(body_.size());
  cycle.pair_row = pair_row_;
  cycle.vertex_blocks = vertex_blocks_.data();
  cycle.triangle_blocks = triangle_blocks_.data();
  cycle.vertex_block_count = vertex_block_count_;
  cycle.triangle_block_count = triangle_block_count_;
  cycle.triangle_count = triangle_count_;
  cycle.received = received_.data();
  cycle.corners = corners_.data();
  cycle.posed = posed_.data();
  cycle.far_vertices = far_vertices_.data();
  cycle.far_count = far_count_.data();
  cycle.body_boxes = body_boxes_.data();
  cycle.vertex_id = vertex_id_.data();
  cycle.identity_table = identity_table_.data();
  cycle.identity_mask = static_cast<std::uint32_t>(identity_table_.size() - 1);
}

CycleParams DeviceScene::params(const Options& options) const {
  CycleParams p{};
  p.overlap = options.overlap;
  p.fuzzifier = options.fuzzifier;
  p.adjacent = options.adjacent;
  p.predicates = options.predicates;
  p.margins = any_margin_ ? 1 : 0;
  p.class_count = class_count_;
  p.classes_exact = classes_exact_ ? 1 : 0;
  // As many buckets for each class as there are, in powers of two.
  p.bucket_shift = 15;
  for (std::uint32_t buckets = 2; buckets * class_count_ <= kBuckets && buckets <= kBuckets;
       buckets *= 2) {
    --p.bucket_shift;
  }
  // The fewer units a scene has, the smaller they must be to share them out evenly.
  constexpr std::uint32_t kFewTriangles = 40000, kManyTriangles = 300000;
  p.unit_columns = triangle_count_ < kFewTriangles    ? kLeastUnitColumns
                   : triangle_count_ < kManyTriangles ? 2 * kLeastUnitColumns
                                                      : 8 * kLeastUnitColumns;
  p.passes = 1;
  p.index_bits = 1;
  while ((std::uint64_t{1} << p.index_bits) <= triangle_count_) ++p.index_bits;
  return p;
}

std::uint64_t DeviceScene::bytes() const {
  return bodies_.bytes() + partners_.bytes() + class_mask_.bytes() + pair_enabled_.bytes() +
         vertex_blocks_.bytes() + triangle_blocks_.bytes() + received_.bytes() + corners_.bytes() +
         body_boxes_.bytes() + vertex_id_.bytes() + identity_table_.bytes() + posed_.bytes() +
         far_vertices_.bytes() + far_count_.bytes();
}

}  // namespace deformable_contact_monitor
