// Reads the options of a deforming object, and plays mesh files or steps a simulated cloth.
#include "tools/common/scene_object.h"

#include <utility>

#include "core/mesh_file.h"

namespace deformable_contact_monitor {

std::vector<MeshFrame> readMeshFrames(const std::vector<std::string>& paths, double scale,
                                      const Eigen::Vector3d& offset,
                                      const std::function<void(std::size_t)>& progress) {
  std::vector<MeshFrame> frames;
  MeshFileReport last_report;
  for (const std::string& path : paths) {
    MeshFrame frame;
    MeshFileReport report;
    frame.mesh = readMeshFile(path, &report);
    // The triangles of polygons are those of the first frame with these faces.
    if (report.fans == last_report.fans) frame.mesh.triangles = frames.back().mesh.triangles;
    last_report = std::move(report);
    for (std::size_t i = 0; i < frame.mesh.vertices.size(); ++i) {
      float& coordinate = frame.mesh.vertices[i];
      coordinate =
          static_cast<float>(scale * coordinate + offset[static_cast<Eigen::Index>(i % 3)]);
    }
    if (!frames.empty()) {
      const MeshFrame& last = frames.back();
      // A new topology_id tells receivers that the triangles changed.
      const bool same = last.mesh.triangles == frame.mesh.triangles &&
                        last.mesh.vertices.size() == frame.mesh.vertices.size();
      frame.topology_id = last.topology_id + (same ? 0 : 1);
    }
    frames.push_back(std::move(frame));
    progress(frames.size());
  }
  return frames;
}

void describe(CommandLine* line, SceneObject* object) {
  line->addWords("--meshes", &object->meshes,
                 "mesh files (OBJ, PLY, STL, OFF) to play in this order");
  line->add("--cloth", &object->cloth_triangles,
            "simulate a square cloth of about this many triangles: it is held at one edge, falls, "
            "and is pushed by the robot; not with --meshes",
            inRange(2, 2000000));
  line->refuseTogether("--cloth", "--meshes");
  line->addFlag("--loop", &object->loop, "play the files again and again");
  line->add("--object", &object->name, "name of the object");
  line->add("--frame", &object->frame,
            "frame of the vertices; with --cloth, a link (default: the robot's root link)");
  line->add("--rate", &object->rate_hz, "messages a second [Hz]", inRange(0.1, 1000.0));
  line->add("--scale", &object->scale,
            "with --meshes, factor to metres; with --cloth, length of its edge [m]", isPositive());
  line->addNumbers(
      "--offset", &object->offset,
      "x y z [m]: with --meshes, added after scaling; with --cloth, middle of the held edge");
  line->add("--seed", &object->seed, "seed of the cloth's random motion");
}

// The source owns the cloth, or all frames of the files.
MeshSource makeMeshSource(const SceneObject& object,
                          const std::function<void(std::size_t)>& progress) {
  if (object.cloth_triangles) {
    ClothOptions options;
    options.triangles = *object.cloth_triangles;
    options.edge_m = object.scale;
    options.held_at = Eigen::Vector3d::Map(object.offset.data());
    options.seed = object.seed;
    return [cloth = Cloth(options), dt_s = 1 / object.rate_hz](
               const std::vector<Capsule>& obstacles) mutable -> std::optional<MeshFrame> {
      cloth.step(dt_s, obstacles);
      return MeshFrame{cloth.mesh(), 0};
    };
  }
  std::vector<MeshFrame> frames = readMeshFrames(
      object.meshes, object.scale, Eigen::Vector3d::Map(object.offset.data()), progress);
  return [frames = std::move(frames), loop = object.loop, next = std::size_t{0}](
             const std::vector<Capsule>& /*obstacles*/) mutable -> std::optional<MeshFrame> {
    if (next == frames.size()) {
      if (!loop) return std::nullopt;
      next = 0;
    }
    return frames[next++];
  };
}

}  // namespace deformable_contact_monitor
