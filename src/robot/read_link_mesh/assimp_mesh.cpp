// Mesh files of robot links, by Assimp.
#include "robot/read_link_mesh/assimp_mesh.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <utility>

#include "robot/mesh_stream.h"
#include "robot/read_link_mesh/collada_check.h"
#include "robot/read_link_mesh/obj_check.h"
#include "robot/read_link_mesh/regular_file.h"
#include "robot/read_link_mesh/single_file.h"
#include "robot/reading_limits.h"

namespace deformable_contact_monitor {
namespace {

// Two seconds of work; drawn outlines of parts have hundreds.
constexpr unsigned kMaxFaceCorners = 20'000;

// In small letters, with its dot. Assimp would go by content next, and read any of its forty
// formats.
std::string knownEnding(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending != ".stl" && ending != ".dae" && ending != ".obj") {
    throw std::runtime_error("'" + ending +
                             "' is no mesh format of robot links: STL, DAE and OBJ are");
  }
  return ending;
}

Eigen::Affine3d toEigen(const aiMatrix4x4& m) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.linear() << m.a1, m.a2, m.a3, m.b1, m.b2, m.b3, m.c1, m.c2, m.c3;
  transform.translation() << m.a4, m.b4, m.c4;
  return transform;
}

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

// Assimp cuts ears off a polygon in quadratic time.
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

// What Assimp throws within comes out as text.
[[noreturn]] void failAsAssimp(const std::string& error) {
  if (error.find("bad_alloc") != std::string::npos) throw std::bad_alloc();
  throw std::runtime_error(error);
}

}  // namespace

SourceMesh readWithAssimp(const std::string& path) {
  const std::string bytes = readRegularFile(path);
  const std::string ending = knownEnding(path);
  if (ending == ".dae") checkCollada(bytes);
  if (ending == ".obj") checkObj(bytes);

  Assimp::Importer importer;
  // Otherwise Assimp turns a COLLADA scene so that y points up. rviz takes that rotation out again.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // And it would draw the skeleton of a scene that has no mesh.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const std::string name = "mesh" + ending;
  importer.SetIOHandler(new SingleFile(name, bytes));  // the importer deletes it
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
