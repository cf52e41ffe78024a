// Poses of frames in the reference frame, at a given stamp, from tf2.
#pragma once

#include <geometry_msgs/Transform.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/rigid_transform.h"

namespace deformable_contact_monitor {

// The matrix of tf2's composed transform. All in double, left to right as written, without FMA:
//   n = sqrt(((x*x + y*y) + z*z) + w*w);  x /= n;  y /= n;  z /= n;  w /= n
//   R = | 1 - 2*(y*y + z*z)   2*(x*y - z*w)       2*(x*z + y*w)     |
//       | 2*(x*y + z*w)       1 - 2*(x*x + z*z)   2*(y*z - x*w)     |
//       | 2*(x*z - y*w)       2*(y*z + x*w)       1 - 2*(x*x + y*y) |
// where x y z w is the quaternion and t the translation [m] that lookupTransform(reference_frame,
// frame, stamp) returns. A vertex v is then float32(R v + t), each row as
// ((r0*v0 + r1*v1) + r2*v2) + t, in double, rounded once (core/rigid_transform.h).
RigidTransform toRigidTransform(const geometry_msgs::Transform& transform);

struct FrameAtStamp {
  std::string frame;
  ros::Time stamp;
};

struct PoseAnswer {
  enum class Outcome {
    kFound,
    kLate,   // newer data may come: the newest are older than the stamp, or went with a reset
    kPast,   // too late: the oldest are newer than the stamp
    kNever,  // no connection to the reference frame has been seen at all
  };
  Outcome outcome = Outcome::kNever;
  RigidTransform pose;  // reference frame from frame, if kFound
  ros::Time available;  // newest stamp with a transform; zero: kLate since a reset
  std::string problem;  // for people: what is missing; empty if kFound
};

// One thread at a time; the buffer may be filled by another.
class TransformLookup {
 public:
  // The buffer must outlive this.
  TransformLookup(const tf2::BufferCore& buffer, std::string reference_frame)
      : buffer_(buffer), reference_frame_(std::move(reference_frame)) {}

  // One answer for each question, in order; never with another stamp's pose. Does not wait.
  std::vector<PoseAnswer> lookup(const std::vector<FrameAtStamp>& frames) const;

  // Whether one of them is late and may yet come: it is nothing that was given up and has not moved
  // on since.
  bool isWorthWaiting(const std::vector<FrameAtStamp>& frames) const;

  // They were waited for in vain, those that are late: a frame that stands still is not waited for
  // again and again.
  void giveUp(const std::vector<FrameAtStamp>& frames);

  // To be called before all transforms are dropped: those of frames that have a pose now will come
  // again. Until they do they are late, and what was given up may be waited for.
  void noteReset();

  // The newest stamp at which all of these frames have a pose, but for those that have none or
  // whose newest is more than `window_s` behind the others'. Zero: all are static; nothing: none
  // has any.
  std::optional<ros::Time> newestCommon(const std::vector<std::string>& frames,
                                        double window_s) const;

 private:
  PoseAnswer ask(const FrameAtStamp& question) const;
  PoseAnswer find(const FrameAtStamp& question) const;
  PoseAnswer explain(const FrameAtStamp& question) const;

  const tf2::BufferCore& buffer_;
  const std::string reference_frame_;
  std::map<std::string, ros::Time> given_up_;  // frames, with their newest stamp then
  std::set<std::string> seen_;                 // frames that had a pose before a reset
};

// Without tf's old leading '/'.
std::string plainFrame(const std::string& frame);

}  // namespace deformable_contact_monitor
