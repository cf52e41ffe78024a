// Joins source meshes into the mesh of a link, in which equal vertices are stored once.
#include "robot/source_mesh.h"

#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMaxCount = std::size_t{1} << 31;
constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

}  // namespace

// Mixes the bits of three coordinates. The factor is 2^64 divided by the golden ratio, an odd
// number whose multiples are spread evenly (Knuth's multiplicative hashing).
std::size_t LinkMeshBuilder::BitsHash::operator()(const Bits& bits) const {
  std::uint64_t hash = 0;
  for (const std::uint32_t word : bits) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15U;
    hash ^= hash >> 29;
  }
  return hash;
}

std::uint32_t LinkMeshBuilder::indexOf(const Eigen::Vector3d& vertex) {
  const float rounded[3] = {static_cast<float>(vertex.x()), static_cast<float>(vertex.y()),
                            static_cast<float>(vertex.z())};
  Bits bits;
  std::memcpy(bits.data(), rounded, sizeof(rounded));
  const auto next = static_cast<std::uint32_t>(mesh_.vertexCount());
  const auto [entry, is_new] = index_of_.emplace(bits, next);
  if (is_new) mesh_.vertices.insert(mesh_.vertices.end(), rounded, rounded + 3);
  return entry->second;
}

void LinkMeshBuilder::append(const SourceMesh& mesh, const Eigen::Affine3d& link_from_source) {
  if (mesh_.vertexCount() + mesh.vertices.size() >= kMaxCount ||
      mesh_.triangleCount() + mesh.triangles.size() >= kMaxCount) {
    throw std::length_error("more than 2^31 vertices or triangles");
  }
  // A mirroring transform turns triangles inside out. Swapping two corners turns them back.
  const bool mirrors = link_from_source.linear().determinant() < 0;
  std::vector<std::uint32_t> indices(mesh.vertices.size(), kUnused);
  for (std::array<std::uint32_t, 3> triangle : mesh.triangles) {
    if (mirrors) std::swap(triangle[1], triangle[2]);
    for (const std::uint32_t corner : triangle) {
      // Only vertices that a triangle uses are transformed and stored.
      std::uint32_t& index = indices.at(corner);
      if (index == kUnused) index = indexOf(link_from_source * mesh.vertices[corner]);
      mesh_.triangles.push_back(index);
    }
  }
}

}  // namespace deformable_contact_monitor
