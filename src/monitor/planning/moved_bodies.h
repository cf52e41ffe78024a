// Which bodies the states of a question move, and where they are in each state.
#pragma once

#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "core/scene.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_kinematics.h"

namespace deformable_contact_monitor {

// The links that named joints move, and the rigid objects that go with these links: those whose TF
// frame is a link's, or is below it in TF, and those that such a link carries (~attach_object). A
// robot whose root is below a link of another robot in TF is carried by that link. A mesh never
// moves with the robot, also one that was seen from a link, or that a link holds. One thread at a
// time.
class MovedBodies {
 public:
  // Finds out which bodies of the scene move. All arguments must outlive this. Throws
  // std::invalid_argument, naming the joint, as JointMotion does.
  MovedBodies(const std::vector<RobotJoint>& joints, const std::vector<std::string>& names,
              const MonitorScene& scene, const MonitorParameters& parameters,
              const tf2::BufferCore& transforms);

  // Returns whether the states move a body of the scene.
  bool isMoved(BodyId id) const { return id < bodies_.size() && bodies_[id].is_moved; }
  // Returns whether nobody knows if they do, as neither TF nor the URDF connects the body to the
  // reference frame.
  bool isUnclear(BodyId id) const { return id < bodies_.size() && bodies_[id].is_unclear; }

  // Returns the TF frames whose present poses are needed to pose these bodies, but for the
  // reference frame.
  std::vector<std::string> presentFrames(const std::set<BodyId>& bodies) const;

  // Looks up where everything is that the states start from. Returns why no body can be posed,
  // naming a frame; empty: all can be posed but those of which problemOf() says why not.
  std::string lookUp(const ros::Time& t, const TransformLookup& lookup);
  // Returns why lookUp() did not find where a rigid object is in the link that it goes with; empty:
  // that is known, or the states do not move the body.
  std::string problemOf(BodyId id) const {
    return id < bodies_.size() ? bodies_[id].problem : std::string();
  }

  // Writes the poses of `bodies`, which must all be moved, in the reference frame, in their order,
  // for one position of each named joint. Call lookUp() before. A body with a problem gets a pose
  // that means nothing.
  void pose(const double* positions, const std::vector<BodyId>& bodies, RigidTransform* poses);

  bool isBeyondLimits(const double* positions) const { return motion_.isBeyondLimits(positions); }

 private:
  struct MovedBody {
    bool is_moved = false, is_unclear = false;
    std::size_t link = 0;     // among the motion's moved links
    std::string frame{};      // of a rigid object, below that of the link; empty: they are the same
    RigidTransform in_frame;  // where the body is in its frame
    RigidTransform in_link;   // where the body is in the link's frame
    std::string problem{};    // why in_link is not known; empty: it is
  };

  void findCarrier(const FramePlace& place, const std::vector<RobotJoint>& joints,
                   const std::string& root, MovedBody* body) const;

  const MonitorParameters& parameters_;
  const tf2::BufferCore& transforms_;
  JointMotion motion_;
  std::vector<MovedBody> bodies_;  // by BodyId: links and rigid objects
  std::vector<RigidTransform> links_;
};

}  // namespace deformable_contact_monitor
