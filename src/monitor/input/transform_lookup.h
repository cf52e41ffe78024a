// Looks up poses of frames in the reference frame at a given stamp, and explains missing ones.
#pragma once

#include <geometry_msgs/Transform.h>
#include <ros/time.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "monitor/input/transform_buffer.h"

namespace deformable_contact_monitor {

// Returns the matrix of a transform from tf2, computed in double, from left to right as written,
// without FMA:
//   n = sqrt(((x*x + y*y) + z*z) + w*w);  x /= n;  y /= n;  z /= n;  w /= n
//   R = | 1 - 2*(y*y + z*z)   2*(x*y - z*w)       2*(x*z + y*w)     |
//       | 2*(x*y + z*w)       1 - 2*(x*x + z*z)   2*(y*z - x*w)     |
//       | 2*(x*z - y*w)       2*(y*z + x*w)       1 - 2*(x*x + y*y) |
// where x y z w is the quaternion and t the translation [m] that lookupTransform(reference_frame,
// frame, stamp) returns. A vertex v is then float32(R v + t), each row as
// ((r0*v0 + r1*v1) + r2*v2) + t, in double, rounded once (core/rigid_transform.h).
RigidTransform toRigidTransform(const geometry_msgs::Transform& transform);

// A frame whose pose is asked for.
struct FrameAtStamp {
  std::string frame;
  ros::Time stamp;
  std::string link{};  // whose frame it is; empty: it is no link's
};

// The pose of a frame at a stamp, or why it is not known.
struct PoseAnswer {
  enum class Outcome {
    kFound,
    kLate,   // may still come: transforms are older than the stamp, or were forgotten
    kPast,   // will not come: transforms are newer than the stamp, or the buffer has a problem
    kNever,  // nothing has ever connected the frame to the reference frame
  };
  Outcome outcome = Outcome::kNever;
  RigidTransform pose;  // if kFound: maps points of the frame to the reference frame
  ros::Time available;  // newest stamp with a transform; zero: none
  std::string problem;  // says what is missing; empty if kFound
};

// Never waits. One thread at a time; another thread may fill the buffer meanwhile.
class TransformLookup {
 public:
  // The buffer must outlive this.
  TransformLookup(const TransformBuffer& buffer, std::string reference_frame)
      : buffer_(buffer), reference_frame_(std::move(reference_frame)) {}

  // Returns one answer for each question, in their order. A pose is always that of the very stamp.
  // If the frame of a link, or the reference frame, was never seen, the problem proposes frames
  // that have a prefix before that name.
  std::vector<PoseAnswer> lookup(const std::vector<FrameAtStamp>& frames) const;

  // Returns whether one of these poses is late but may still come. A pose for which giveUp() was
  // called does not count, until its frame has received a newer transform.
  bool isWorthWaiting(const std::vector<FrameAtStamp>& frames) const;

  // Notes that a cycle waited in vain for those poses that are late, so that no other cycle waits
  // for a frame that nobody publishes any more.
  void giveUp(const std::vector<FrameAtStamp>& frames);

  // Must be called after all transforms were dropped. Frames that had a pose are expected to come
  // again: until they do they count as late, also if giveUp() noted them before.
  void noteReset() { given_up_.clear(); }

  // Returns the newest stamp at which all of these frames have a pose. Frames without any pose are
  // left out, and so are those whose newest pose is more than `window_s` [s] behind that of the
  // others, or behind `now` if theirs are stamped ahead of it; zero: there is no clock. Those whose
  // newest pose is not later than `after` are left out, too, if any is later. Returns zero if all
  // frames are static, and nothing if no frame has a pose.
  std::optional<ros::Time> newestCommon(const std::vector<std::string>& frames, double window_s,
                                        const ros::Time& now,
                                        const ros::Time& after = ros::Time()) const;

 private:
  PoseAnswer ask(const FrameAtStamp& question) const;
  // What TransformBuffer::problemAt() says of it.
  std::string problemOf(const FrameAtStamp& question) const;
  // kNever: tf2 gives no pose.
  PoseAnswer find(const FrameAtStamp& question) const;
  PoseAnswer explain(const FrameAtStamp& question) const;
  std::string prefixHint(const FrameAtStamp& question) const;

  const TransformBuffer& buffer_;
  const std::string reference_frame_;
  std::map<std::string, ros::Time> given_up_;  // the newest stamp then, by frame
};

// Returns the frame's name without the leading '/' of tf1.
std::string plainFrame(const std::string& frame);

}  // namespace deformable_contact_monitor
