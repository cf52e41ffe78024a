// A deforming object that the command line describes: a sequence of mesh files, or a simulated
// cloth.
//
// evaluate_bag and scene_publisher both use it, so a scene can be played live or evaluated offline.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"
#include "tools/common/cloth.h"
#include "tools/common/command_line.h"

namespace deformable_contact_monitor {

// One state of the object.
struct MeshFrame {
  TriangleMesh mesh;              // [m]
  std::uint32_t topology_id = 0;  // changes if and only if the triangles change
};

// Reads the files in order. A vertex v becomes scale * v + offset [m]. Calls `progress` with the
// number of files read so far. Throws std::runtime_error as readMeshFile does.
std::vector<MeshFrame> readMeshFrames(const std::vector<std::string>& paths, double scale,
                                      const Eigen::Vector3d& offset,
                                      const std::function<void(std::size_t)>& progress);

// The options of a deforming object.
struct SceneObject {
  std::vector<std::string> meshes;     // files; empty: a cloth, or no object
  std::optional<int> cloth_triangles;  // nothing: no cloth
  bool loop = false;                   // play the files again and again
  std::string name = "cloth";
  std::string frame;  // of the vertices; empty: the robot's root link
  double rate_hz = 30;
  double scale = 1;                        // of mesh files; a cloth's edge [m]
  std::vector<double> offset = {0, 0, 0};  // added to vertices [m]; middle of a cloth's held edge
  std::uint32_t seed = 1;                  // of a cloth's random motion

  bool isWanted() const { return !meshes.empty() || cloth_triangles; }
};

// Adds these options to the command line: --meshes, --cloth, --loop, --object, --frame, --rate,
// --scale, --offset and --seed.
void describe(CommandLine* line, SceneObject* object);

// Returns the next state; nothing after the last file. Obstacles push a cloth.
using MeshSource = std::function<std::optional<MeshFrame>(const std::vector<Capsule>& obstacles)>;

// Makes the source of an object that isWanted(). Throws and calls `progress` as readMeshFrames
// does.
MeshSource makeMeshSource(const SceneObject& object,
                          const std::function<void(std::size_t)>& progress);

}  // namespace deformable_contact_monitor
