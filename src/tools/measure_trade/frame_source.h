// The sequences of scenes that measure_trade measures on: mesh files, or the cycles of bags.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/scene.h"
#include "tools/common/bag_files.h"

namespace deformable_contact_monitor {

// A sequence of scenes. Bodies, their names and their numbers are the same in every frame; the
// pairs of a body that is missing in a frame are disabled there. Use it from one thread at a time.
class FrameSource {
 public:
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  // Sources are deleted through this class.
  virtual ~FrameSource() = default;

  // Makes scene() the next frame. Returns false and changes nothing after the last frame. Throws
  // std::runtime_error, one line that names the source, if the frame cannot be read.
  virtual bool next() = 0;

  // Goes back to the beginning: the same frames come again, in the same order.
  void rewind() { next_ = 0; }

  // Returns the frame of the last next(). Before the first call, it has all bodies and names
  // already.
  const Scene& scene() const { return scene_; }

  // Sets the margin of all bodies in all frames that follow [m].
  void setMargin(float margin_m) {
    for (BodyId body = 0; body < scene_.bodyCount(); ++body) scene_.setMargin(body, margin_m);
  }

  // Returns true if the body deforms. Otherwise it is rigid, such as a robot's link.
  virtual bool isDeformable(BodyId body) const = 0;

  // Returns false if nobody knows the body's path from the frame before to this one: it was away,
  // or the clock went back.
  virtual bool hasPath(BodyId /*body*/) const { return true; }

  // Returns the classes of pairs that are enabled, with the names of the node's `pair_classes`.
  virtual std::vector<std::string> pairClasses() const { return {"robot_deformable"}; }

  // Returns the name of the last frame for people: a file or a stamp.
  virtual std::string label() const = 0;

 protected:
  Scene scene_;
  std::size_t next_ = 0;  // the frame that next() shows
};

// Mesh files as the states of one deforming body among bodies that do not move.
struct MeshFrameFiles {
  std::vector<std::string> states;   // body 0 in each frame, at least one; triangles may change
  std::vector<std::string> against;  // the other bodies, numbered from 1
  bool self = false;                 // also find contacts of body 0 with itself
  int split = 1;  // divide the path between two states of the same triangles into so many steps
};

// Reads all files, and calls `progress` with their names. A body is named by its file without
// folder and ending; body 0 by its first file. Throws std::runtime_error as readMeshFile does, and
// std::invalid_argument if two bodies would have the same name.
std::unique_ptr<FrameSource> makeMeshFrames(
    const MeshFrameFiles& files, const std::function<void(const std::string&)>& progress);

// Reads bags: one frame for each cycle that evaluate_bag would evaluate, with its pairs of bodies.
// If there are more than `most_frames` (0: no limit), keeps only every second, fourth, eighth, ...
// cycle, and at least half as many as that. Keeps the deforming vertices of all frames in memory.
// Forks, so call it before anything starts threads; `progress`, which gets what is being read, may
// start one. `warn` gets what a user should know. Throws std::runtime_error, one line, if a bag
// cannot be read completely, and always in a build without ROS.
std::unique_ptr<FrameSource> makeBagFrames(const BagFiles& files, std::size_t most_frames,
                                           const std::function<void(const std::string&)>& progress,
                                           const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
