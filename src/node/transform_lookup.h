// Poses of frames in the reference frame, at a given stamp, from tf2.
#pragma once

#include <geometry_msgs/Transform.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <string>
#include <vector>

#include "core/rules/rigid_transform.h"

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
    kLate,   // newer data may come: the newest are older than the stamp
    kPast,   // too late: the oldest are newer than the stamp
    kNever,  // no connection to the reference frame has been seen at all
  };
  Outcome outcome = Outcome::kNever;
  RigidTransform pose;  // reference frame from frame, if kFound
  ros::Time available;  // newest stamp with a transform, if kLate or kPast
  std::string problem;  // for people: what is missing; empty if kFound
};

struct PoseAnswers {
  std::vector<PoseAnswer> answers;  // one for each question, in order
  double waited_s = 0;
};

// One thread at a time; the buffer may be filled by another.
class TransformLookup {
 public:
  // The buffer must outlive this.
  TransformLookup(const tf2::BufferCore& buffer, std::string reference_frame, double timeout_s)
      : buffer_(buffer), reference_frame_(std::move(reference_frame)), timeout_s_(timeout_s) {}

  // Waits until all are there or the late ones have been waited for during timeout_s [wall time].
  // A frame that is kNever or kPast is not waited for. Never answers with another stamp's pose.
  PoseAnswers lookup(const std::vector<FrameAtStamp>& frames) const;

 private:
  PoseAnswer ask(const FrameAtStamp& question) const;
  PoseAnswer find(const FrameAtStamp& question) const;
  PoseAnswer explain(const FrameAtStamp& question) const;

  const tf2::BufferCore& buffer_;
  const std::string reference_frame_;
  const double timeout_s_;
};

// Without tf's old leading '/'.
std::string plainFrame(const std::string& frame);

}  // namespace deformable_contact_monitor
