// A deforming object that the command line describes: a sequence of mesh files, or a simulated
// object.
//
// evaluate_bag and soft_scene both use it, so a scene can be played live or evaluated offline.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"
#include "robot/robot_geometry.h"
#include "tools/common/command_line.h"
#include "tools/simulation/soft_shape.h"

namespace deformable_contact_monitor {

class SoftWorld;

// Returns the pose of a link in the frame of the object; nothing if it is not known.
using LinkPose = std::function<std::optional<Eigen::Isometry3d>(const std::string& link)>;

// One state of the object.
struct MeshFrame {
  TriangleMesh mesh;              // [m]
  std::uint32_t topology_id = 0;  // changes if and only if the triangles change
  std::string problem;            // why the simulation undid a step, one line; empty: it did not
};

// Reads the files in order. A vertex v becomes scale * v + offset [m]. Calls `progress` with the
// number of files read so far. Throws std::runtime_error as readMeshFile does.
std::vector<MeshFrame> readMeshFrames(const std::vector<std::string>& paths, double scale,
                                      const Eigen::Vector3d& offset,
                                      const std::function<void(std::size_t)>& progress);

// The options of a deforming object.
struct SceneObject {
  std::vector<std::string> meshes;  // files to play; empty: simulate, or no object
  // What is simulated, nothing if shape.object is empty. Its size is the scale of files too, and
  // its offset is the one below.
  SoftShapeOptions shape{""};
  bool loop = false;  // play the files again and again
  std::string name = "cloth";
  std::string frame;  // of the vertices; empty: the robot's root link
  double rate_hz = 30;
  std::vector<double> offset = {0, 0, 0};  // added to vertices [m]; place of what is simulated
  // Of what is simulated:
  double radius_m = 0.01;    // of a rope
  double margin_m = 0.001;   // Bullet's, of all but a rope
  double step_s = 1 / 240.;  // longest step of the simulation
  std::optional<double> floor_m;

  bool isWanted() const { return !meshes.empty() || !shape.object.empty(); }
  bool isRope() const { return shape.object == "rope"; }
};

// Adds these options to the command line.
void describe(CommandLine* line, SceneObject* object);

// Makes the world of an object that is simulated, with all links of the robot that have usable
// geometry. Throws std::runtime_error if this program was built without Bullet, and what
// softShape() throws.
std::shared_ptr<SoftWorld> makeSoftWorld(const SceneObject& object, const RobotGeometry& robot);

// Returns the next state; nothing after the last file. Links push what is simulated.
using MeshSource = std::function<std::optional<MeshFrame>(const LinkPose& pose_of)>;

// Makes the source of an object that is played from files; `progress` as readMeshFrames.
MeshSource makeFileSource(const SceneObject& object,
                          const std::function<void(std::size_t)>& progress);

// Makes the source of what is simulated.
MeshSource makeSoftSource(const SceneObject& object, std::shared_ptr<SoftWorld> world);

}  // namespace deformable_contact_monitor
