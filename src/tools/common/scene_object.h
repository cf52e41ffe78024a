// A deforming object from the command line: mesh files in turn, or a simulated cloth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/common/cloth.h"
#include "tools/common/command_line.h"
#include "tools/common/mesh_player.h"

namespace deformable_contact_monitor {

struct SceneObject {
  std::vector<std::string> meshes;
  std::optional<int> cloth_triangles;  // none: no cloth
  bool loop = false;
  std::string name = "cloth";
  std::string frame;  // of the vertices; empty: the robot's root link
  double rate_hz = 30;
  double scale = 1;
  std::vector<double> offset = {0, 0, 0};
  std::uint32_t seed = 1;

  bool isWanted() const { return !meshes.empty() || cloth_triangles; }
};

// Adds --meshes, --cloth, --loop, --object, --frame, --rate, --scale, --offset and --seed.
void describe(CommandLine* line, SceneObject* object);

// The next state, pushed by `obstacles` if it is a cloth; nothing when the files are at their end.
using MeshSource = std::function<std::optional<MeshFrame>(const std::vector<Capsule>& obstacles)>;

// One that isWanted(). Throws and calls `progress` as readMeshFrames does.
MeshSource makeMeshSource(const SceneObject& object,
                          const std::function<void(std::size_t)>& progress);

}  // namespace deformable_contact_monitor
