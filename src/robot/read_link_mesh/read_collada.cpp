// Reads COLLADA with Assimp: checks the text, imports it, and joins the meshes of all nodes in the
// frame of the file. Polygons become triangles as in the other formats, because Assimp fills
// notches of polygons with corners on one line.
#include "robot/read_link_mesh/read_collada.h"

#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/mesh_files/polygons.h"
#include "robot/mesh_stream.h"
#include "robot/read_link_mesh/check_collada.h"
#include "robot/reading_limits.h"

namespace deformable_contact_monitor {
namespace {

// The only file that Assimp may open. Materials, textures and other files that a mesh file names do
// not exist for it: they do not change the shape, and might be a secret, a FIFO or a device.
class SingleFile : public Assimp::IOSystem {
 public:
  // `bytes` must outlive this.
  SingleFile(std::string name, const std::string& bytes) : name_(std::move(name)), bytes_(bytes) {}

  bool Exists(const char* name) const override { return name == name_; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    if (name != name_ || *mode != 'r') return nullptr;
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes_.data()),
                                      bytes_.size());
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  const std::string name_;
  const std::string& bytes_;
};

// Assimp's matrices are stored row by row, and the fourth column is the translation.
Eigen::Affine3d toEigen(const aiMatrix4x4& m) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.linear() << m.a1, m.a2, m.a3, m.b1, m.b2, m.b3, m.c1, m.c2, m.c3;
  transform.translation() << m.a4, m.b4, m.c4;
  return transform;
}

void requireRoom(std::size_t vertices, std::size_t triangles) {
  if (fitsMeshLimit(vertices, triangles, kMaxMeshMib * kBytesPerMib)) return;
  throw std::length_error("more than " + std::to_string(kMaxMeshMib) +
                          " MiB of vertices and triangles");
}

// The meshes of a file one after another, each in the frame of its node. Mesh m has the vertices
// from first_vertex[m] to before first_vertex[m + 1], and alike the indices.
struct FileMeshes {
  HostList<float> coordinates;        // three for each vertex
  HostList<std::uint32_t> triangles;  // three indices for each triangle, among all vertices
  std::vector<std::size_t> first_vertex, first_index;
};

// Adds the vertices and faces of a mesh. Points and lines are left out.
void appendFaces(const aiMesh& from, FileMeshes& to, PolygonList& polygons) {
  const std::size_t first = to.coordinates.size() / 3;
  to.first_vertex.push_back(first);
  to.first_index.push_back(to.triangles.size());
  requireRoom(first + from.mNumVertices, to.triangles.size() / 3 + from.mNumFaces);
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    const aiVector3D& v = from.mVertices[i];
    to.coordinates.insert(to.coordinates.end(), {v.x, v.y, v.z});
  }
  for (unsigned i = 0; i < from.mNumFaces; ++i) {
    const aiFace& face = from.mFaces[i];
    if (face.mNumIndices < 3) continue;
    polygons.begin();
    for (unsigned corner = 0; corner < face.mNumIndices; ++corner) {
      if (face.mIndices[corner] >= from.mNumVertices) {
        throw std::out_of_range("a face has a vertex index out of range");
      }
      polygons.add(static_cast<std::uint32_t>(first + face.mIndices[corner]));
    }
  }
}

// Returns all meshes of a file with triangles in the place of polygons.
FileMeshes trianglesOf(const aiScene& scene, MeshFileReport* report) {
  FileMeshes meshes;
  PolygonList polygons(&meshes.triangles);
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) appendFaces(*scene.mMeshes[i], meshes, polygons);
  meshes.first_vertex.push_back(meshes.coordinates.size() / 3);
  meshes.first_index.push_back(meshes.triangles.size());
  polygons.triangulate(meshes.coordinates, report);
  return meshes;
}

// Adds a mesh, whose vertices are in the frame of a node. A transform that mirrors would turn
// triangles inside out, so two of their corners are swapped then.
void appendMesh(const FileMeshes& from, unsigned mesh, const Eigen::Affine3d& file_from_node,
                SourceMesh& to) {
  const std::size_t begin = from.first_vertex[mesh], end = from.first_vertex[mesh + 1];
  const std::size_t first = to.vertices.size();
  requireRoom(first + end - begin,
              to.triangles.size() + (from.first_index[mesh + 1] - from.first_index[mesh]) / 3);
  for (std::size_t i = begin; i < end; ++i) {
    const float* const v = &from.coordinates[3 * i];
    to.vertices.push_back(file_from_node * Eigen::Vector3d(v[0], v[1], v[2]));
  }
  const bool mirrors = file_from_node.linear().determinant() < 0;
  for (std::size_t i = from.first_index[mesh]; i < from.first_index[mesh + 1]; i += 3) {
    std::array<std::uint32_t, 3> triangle;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      triangle[corner] = static_cast<std::uint32_t>(first + from.triangles[i + corner] - begin);
    }
    if (mirrors) std::swap(triangle[1], triangle[2]);
    to.triangles.push_back(triangle);
  }
}

// Adds the meshes of a node and of its children, depth first, in the order of the file.
void appendNode(const FileMeshes& meshes, const aiNode& node,
                const Eigen::Affine3d& file_from_parent, SourceMesh& to) {
  const Eigen::Affine3d file_from_node = file_from_parent * toEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    appendMesh(meshes, node.mMeshes[i], file_from_node, to);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    appendNode(meshes, *node.mChildren[i], file_from_node, to);
  }
}

// Throws an error of Assimp, which passes on its own exceptions as text alone.
[[noreturn]] void failAsAssimp(const std::string& error) {
  if (error.find("bad_alloc") != std::string::npos) throw std::bad_alloc();
  throw std::runtime_error(error);
}

}  // namespace

SourceMesh readCollada(const std::string& text, MeshFileReport* report) {
  checkCollada(text);
  Assimp::Importer importer;
  // Keeps the axes of a COLLADA file. Without this, Assimp rotates the scene so that y points up,
  // and rviz takes that rotation out again.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // Without this, Assimp makes a mesh of the skeleton of a scene that has no mesh.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const std::string name = "mesh.dae";
  importer.SetIOHandler(new SingleFile(name, text));  // the importer deletes it
  // Reads without any post-processing: vertices are not to be joined.
  const aiScene* const scene = importer.ReadFile(name, 0);
  if (scene == nullptr || scene->mRootNode == nullptr) failAsAssimp(importer.GetErrorString());
  SourceMesh mesh;
  const FileMeshes meshes = trianglesOf(*scene, report);
  appendNode(meshes, *scene->mRootNode, Eigen::Affine3d::Identity(), mesh);
  if (mesh.triangles.empty()) throw std::runtime_error("holds no triangle");
  return mesh;
}

}  // namespace deformable_contact_monitor
