// A deforming object from the command line: mesh files in turn, or a simulated cloth.
#include "tools/common/scene_object.h"

#include <Eigen/Core>
#include <utility>

namespace deformable_contact_monitor {

void describe(CLI::App* app, SceneObject* object) {
  auto* meshes = app->add_option("--meshes", object->meshes,
                                 "mesh files (OBJ, PLY, STL, OFF), played in this order");
  app->add_option("--cloth", object->cloth_triangles,
                  "make a square cloth of about so many triangles that is held at one edge, falls, "
                  "and is pushed by the robot")
      ->check(CLI::Range(2, 2000000))
      ->excludes(meshes);
  app->add_flag("--loop", object->loop, "play the files again and again");
  app->add_option("--object", object->name, "name of the object")->capture_default_str();
  app->add_option("--frame", object->frame,
                  "frame of the vertices; a link, for --cloth (default: the robot's root link)");
  app->add_option("--rate", object->rate_hz, "messages a second [Hz]")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  app->add_option("--scale", object->scale, "meshes: factor to metres; cloth: its edge [m]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app->add_option("--offset", object->offset,
                  "x y z [m]: meshes: added after scaling; cloth: middle of the held edge")
      ->expected(3);
  app->add_option("--seed", object->seed, "of what is random")->capture_default_str();
}

MeshSource makeMeshSource(const SceneObject& object,
                          const std::function<void(std::size_t)>& progress) {
  if (object.cloth_triangles > 0) {
    ClothOptions options;
    options.triangles = object.cloth_triangles;
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
