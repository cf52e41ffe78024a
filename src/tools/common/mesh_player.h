// Mesh files as the states of one deforming object.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

struct MeshFrame {
  TriangleMesh mesh;              // [m]
  std::uint32_t topology_id = 0;  // differs from the previous frame's iff the triangles differ
};

// Reads the files in order; vertices become scale * v + offset [m]. `progress` is called with the
// number of files read so far. Throws std::runtime_error as readMeshFile does.
std::vector<MeshFrame> readMeshFrames(const std::vector<std::string>& paths, double scale,
                                      const Eigen::Vector3d& offset,
                                      const std::function<void(std::size_t)>& progress);

}  // namespace deformable_contact_monitor
