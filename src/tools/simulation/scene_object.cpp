// Reads the options of a deforming object, and plays mesh files or steps a simulation.
#include "tools/simulation/scene_object.h"

#include <stdexcept>
#include <utility>

#include "core/mesh_file.h"
#ifdef DCM_WITH_BULLET
#include "tools/simulation/soft_world.h"
#endif

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
  line->add("--object", &object->shape.object,
            "simulate this, and let the robot push it: cloth, rope, volume, or a mesh file; not "
            "with --meshes");
  line->refuseTogether("--object", "--meshes");
  line->addFlag("--loop", &object->loop, "play the files again and again");
  line->add("--name", &object->name, "name of the object in messages");
  line->add("--frame", &object->frame,
            "frame of the vertices, which should stand still if the object is simulated (default: "
            "the robot's root link)");
  line->add("--rate", &object->rate_hz, "messages a second [Hz]", inRange(0.1, 1000.0));
  line->add("--scale", &object->shape.size_m,
            "files: factor to metres; cloth: length of its edge [m]; rope: its length; volume: its "
            "diameter",
            isPositive());
  line->addNumbers("--offset", &object->offset,
                   "x y z [m]: files: added after scaling; cloth: middle of its first edge; rope: "
                   "its first end; volume: its middle");
  line->add("--seed", &object->shape.seed, "seed of small random differences");
  line->add("--vertices", &object->shape.vertices, "about how many a cloth, rope or volume has",
            inRange(2, 100000));
  line->add("--pinned", &object->shape.pinned, "what never moves of what is simulated",
            oneOf({"edge", "corners", "none"}));
  line->add("--radius", &object->radius_m, "of a rope [m]", isPositive());
  line->add("--margin", &object->margin_m,
            "Bullet keeps the vertices of a cloth, volume or file so far from links [m]",
            isPositive());
  line->add("--step", &object->step_s, "longest step of the simulation [s]", inRange(1e-5, 1.0));
  line->add("--floor", &object->floor_m, "height of a table below what is simulated [m]");
}

std::shared_ptr<SoftWorld> makeSoftWorld(const SceneObject& object, const RobotGeometry& robot) {
#ifdef DCM_WITH_BULLET
  SoftShapeOptions shape = object.shape;
  shape.offset = Eigen::Vector3d::Map(object.offset.data());
  SoftWorldOptions options;
  options.step_s = object.step_s;
  options.margin_m = object.isRope() ? object.radius_m : object.margin_m;
  auto world = std::make_shared<SoftWorld>(softShape(shape), options);
  for (const LinkGeometry& link : robot.links) {
    if (link.problem.empty()) world->addLink(link.link, link.mesh);
  }
  if (object.floor_m) world->addFloor(*object.floor_m);
  return world;
#else
  (void)robot;
  throw std::runtime_error("--object " + object.shape.object +
                           ": this program was built without Bullet, so it cannot simulate");
#endif
}

MeshSource makeFileSource(const SceneObject& object,
                          const std::function<void(std::size_t)>& progress) {
  std::vector<MeshFrame> frames = readMeshFrames(
      object.meshes, object.shape.size_m, Eigen::Vector3d::Map(object.offset.data()), progress);
  return [frames = std::move(frames), loop = object.loop,
          next = std::size_t{0}](const LinkPose& /*pose_of*/) mutable -> std::optional<MeshFrame> {
    if (next == frames.size()) {
      if (!loop) return std::nullopt;
      next = 0;
    }
    return frames[next++];
  };
}

MeshSource makeSoftSource(const SceneObject& object, std::shared_ptr<SoftWorld> world) {
#ifdef DCM_WITH_BULLET
  return [world = std::move(world),
          dt_s = 1 / object.rate_hz](const LinkPose& pose_of) -> std::optional<MeshFrame> {
    Advance advance = world->advance(dt_s, pose_of);
    if (advance.restarted) advance.problem += "; the object starts anew";
    return MeshFrame{world->mesh(), 0, advance.problem};
  };
#else
  (void)object;
  (void)world;
  return nullptr;
#endif
}

}  // namespace deformable_contact_monitor
