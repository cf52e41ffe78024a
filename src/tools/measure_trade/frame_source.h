// Scenes one after another, wherever they come from.
#pragma once

#include <string>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// Bodies, their names and numbers are the same in every frame; a body that is missing in one has
// its pairs off there. One thread at a time.
class FrameSource {
 public:
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  virtual ~FrameSource() = default;

  // Brings the next frame into scene(); false, and nothing changes, where there is none. Throws
  // std::runtime_error, one line that names the source, if it cannot be read.
  virtual bool next() = 0;

  // Before the first frame again: the same frames come, in the same order.
  virtual void rewind() = 0;

  // Of the last next(); before the first, its bodies and names are there already.
  virtual const Scene& scene() const = 0;

  // Whether the body deforms; else it is a robot's link or another rigid one.
  virtual bool isDeformable(BodyId body) const = 0;

  // The classes of pairs that are looked at, by the names of the node's `pair_classes`; the node's
  // default where a source does not say otherwise.
  virtual std::vector<std::string> pairClasses() const { return {"robot_deformable"}; }

  // Names the last frame for people: a file, a stamp.
  virtual std::string label() const = 0;
};

}  // namespace deformable_contact_monitor
