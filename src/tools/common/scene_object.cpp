// A deforming object from the command line: mesh files in turn, or a simulated cloth.
#include "tools/common/scene_object.h"

#include <Eigen/Core>
#include <utility>

namespace deformable_contact_monitor {

void describe(CommandLine* line, SceneObject* object) {
  line->addWords("--meshes", &object->meshes,
                 "mesh files (OBJ, PLY, STL, OFF), played in this order");
  line->add("--cloth", &object->cloth_triangles,
            "make a square cloth of about so many triangles that is held at one edge, falls, and "
            "is pushed by the robot; not with --meshes",
            inRange(2, 2000000));
  line->refuseTogether("--cloth", "--meshes");
  line->addFlag("--loop", &object->loop, "play the files again and again");
  line->add("--object", &object->name, "name of the object");
  line->add("--frame", &object->frame,
            "frame of the vertices; a link, for --cloth (else: the robot's root link)");
  line->add("--rate", &object->rate_hz, "messages a second [Hz]", inRange(0.1, 1000.0));
  line->add("--scale", &object->scale, "meshes: factor to metres; cloth: its edge [m]",
            isPositive());
  line->addNumbers("--offset", &object->offset,
                   "x y z [m]: meshes: added after scaling; cloth: middle of the held edge");
  line->add("--seed", &object->seed, "of what is random");
}

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
