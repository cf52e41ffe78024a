// Mesh files as the states of one deforming object.
#include "tools/common/mesh_player.h"

#include <utility>

#include "core/mesh_file.h"

namespace deformable_contact_monitor {

std::vector<MeshFrame> readMeshFrames(const std::vector<std::string>& paths, double scale,
                                      const Eigen::Vector3d& offset,
                                      const std::function<void(std::size_t)>& progress) {
  std::vector<MeshFrame> frames;
  for (const std::string& path : paths) {
    MeshFrame frame;
    frame.mesh = readMeshFile(path);
    for (std::size_t i = 0; i < frame.mesh.vertices.size(); ++i) {
      float& coordinate = frame.mesh.vertices[i];
      coordinate =
          static_cast<float>(scale * coordinate + offset[static_cast<Eigen::Index>(i % 3)]);
    }
    if (!frames.empty()) {
      const MeshFrame& last = frames.back();
      const bool same = last.mesh.triangles == frame.mesh.triangles &&
                        last.mesh.vertices.size() == frame.mesh.vertices.size();
      frame.topology_id = last.topology_id + (same ? 0 : 1);
    }
    frames.push_back(std::move(frame));
    progress(frames.size());
  }
  return frames;
}

}  // namespace deformable_contact_monitor
