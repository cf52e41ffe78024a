// Reads COLLADA with Assimp: checks the text, imports it, triangulates polygons, and joins the
// meshes of all nodes in the frame of the file.
#include "robot/read_link_mesh/read_collada.h"

#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <utility>

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

// The most corners that a face may have. Assimp takes two seconds to triangulate such a face. The
// outlines of drawn parts have hundreds of corners.
constexpr unsigned kMaxFaceCorners = 20'000;

// Assimp's matrices are stored row by row, and the fourth column is the translation.
Eigen::Affine3d toEigen(const aiMatrix4x4& m) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.linear() << m.a1, m.a2, m.a3, m.b1, m.b2, m.b3, m.c1, m.c2, m.c3;
  transform.translation() << m.a4, m.b4, m.c4;
  return transform;
}

// Adds the triangles of one of Assimp's meshes, whose vertices are in the frame of a node. A
// transform that mirrors would turn triangles inside out, so two of their corners are swapped then.
void appendMesh(const aiMesh& from, const Eigen::Affine3d& file_from_node, SourceMesh& to) {
  const std::size_t first = to.vertices.size();
  if (!fitsMeshLimit(first + from.mNumVertices, to.triangles.size() + from.mNumFaces,
                     kMaxMeshMib * kBytesPerMib)) {
    throw std::length_error("more than " + std::to_string(kMaxMeshMib) +
                            " MiB of vertices and triangles");
  }
  for (unsigned i = 0; i < from.mNumVertices; ++i) {
    const aiVector3D& v = from.mVertices[i];
    to.vertices.push_back(file_from_node * Eigen::Vector3d(v.x, v.y, v.z));
  }
  const bool mirrors = file_from_node.linear().determinant() < 0;
  for (unsigned i = 0; i < from.mNumFaces; ++i) {
    const aiFace& face = from.mFaces[i];
    if (face.mNumIndices != 3) continue;  // a point or a line
    std::array<std::uint32_t, 3> triangle;
    for (int corner = 0; corner < 3; ++corner) {
      if (face.mIndices[corner] >= from.mNumVertices) {
        throw std::out_of_range("a face has a vertex index out of range");
      }
      triangle[corner] = static_cast<std::uint32_t>(first + face.mIndices[corner]);
    }
    if (mirrors) std::swap(triangle[1], triangle[2]);
    to.triangles.push_back(triangle);
  }
}

// Adds the meshes of a node and of its children, depth first, in the order of the file.
void appendNode(const aiScene& scene, const aiNode& node, const Eigen::Affine3d& file_from_parent,
                SourceMesh& to) {
  const Eigen::Affine3d file_from_node = file_from_parent * toEigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    appendMesh(*scene.mMeshes[node.mMeshes[i]], file_from_node, to);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    appendNode(scene, *node.mChildren[i], file_from_node, to);
  }
}

// Rejects polygons of very many corners, because Assimp cuts ears off them in quadratic time.
void requireModestFaces(const aiScene& scene) {
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[i];
    for (unsigned k = 0; k < mesh.mNumFaces; ++k) {
      if (mesh.mFaces[k].mNumIndices <= kMaxFaceCorners) continue;
      throw std::runtime_error("a face has " + std::to_string(mesh.mFaces[k].mNumIndices) +
                               " corners, and at most " + std::to_string(kMaxFaceCorners) +
                               " are triangulated");
    }
  }
}

// Throws an error of Assimp, which passes on its own exceptions as text alone.
[[noreturn]] void failAsAssimp(const std::string& error) {
  if (error.find("bad_alloc") != std::string::npos) throw std::bad_alloc();
  throw std::runtime_error(error);
}

}  // namespace

SourceMesh readCollada(const std::string& text) {
  checkCollada(text);
  Assimp::Importer importer;
  // Keeps the axes of a COLLADA file. Without this, Assimp rotates the scene so that y points up,
  // and rviz takes that rotation out again.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // Without this, Assimp makes a mesh of the skeleton of a scene that has no mesh.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const std::string name = "mesh.dae";
  importer.SetIOHandler(new SingleFile(name, text));  // the importer deletes it
  // Reads without any post-processing first: faces must be checked before they are triangulated,
  // and vertices are not to be joined.
  const aiScene* scene = importer.ReadFile(name, 0);
  if (scene == nullptr || scene->mRootNode == nullptr) failAsAssimp(importer.GetErrorString());
  requireModestFaces(*scene);
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) failAsAssimp(importer.GetErrorString());
  SourceMesh mesh;
  appendNode(*scene, *scene->mRootNode, Eigen::Affine3d::Identity(), mesh);
  if (mesh.triangles.empty()) throw std::runtime_error("holds no triangle");
  return mesh;
}

}  // namespace deformable_contact_monitor
