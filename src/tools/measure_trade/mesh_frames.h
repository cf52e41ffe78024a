// Mesh files as the states of one deforming body among bodies that stand still.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/measure_trade/frame_source.h"

namespace deformable_contact_monitor {

struct MeshFrameFiles {
  std::vector<std::string> states;   // of body 0, in order, at least one; triangles may change
  std::vector<std::string> against;  // a body each, numbered from 1
  bool self = false;                 // also contacts of body 0 with itself
  int split = 1;  // steps between two states of the same triangles, on straight lines
};

// A body's name is its file's without folder and ending, body 0's the first state's. Reads all
// files; `progress` is told which. Throws std::runtime_error as readMeshFile does, and
// std::invalid_argument where two bodies would have one name.
std::unique_ptr<FrameSource> makeMeshFrames(
    const MeshFrameFiles& files, const std::function<void(const std::string&)>& progress);

}  // namespace deformable_contact_monitor
