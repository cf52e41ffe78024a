// Poses of frames in the reference frame, at a given stamp, from tf2.
#include "node/transform_lookup.h"

#include <tf2/exceptions.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

std::string shown(const ros::Time& stamp) {
  std::ostringstream text;
  text << stamp;
  return text.str();
}

}  // namespace

std::string plainFrame(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

RigidTransform toRigidTransform(const geometry_msgs::Transform& transform) {
  double x = transform.rotation.x, y = transform.rotation.y;
  double z = transform.rotation.z, w = transform.rotation.w;
  const double n = std::sqrt(((x * x + y * y) + z * z) + w * w);
  x /= n;
  y /= n;
  z /= n;
  w /= n;
  RigidTransform pose;
  const double rotation[9] = {
      1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
      2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
      2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
  std::copy(std::begin(rotation), std::end(rotation), std::begin(pose.rotation));
  pose.translation[0] = transform.translation.x;
  pose.translation[1] = transform.translation.y;
  pose.translation[2] = transform.translation.z;
  return pose;
}

PoseAnswers TransformLookup::lookup(const std::vector<FrameAtStamp>& frames) const {
  PoseAnswers result;
  const auto start = Clock::now();
  for (const FrameAtStamp& frame : frames) result.answers.push_back(ask(frame));
  const auto late = [](const PoseAnswer& answer) {
    return answer.outcome == PoseAnswer::Outcome::kLate;
  };
  const auto waited_s = [&start] {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  // Wall time: a clock that stands still must not stop the wait.
  while (std::any_of(result.answers.begin(), result.answers.end(), late) &&
         waited_s() < timeout_s_) {
    std::this_thread::sleep_for(std::chrono::microseconds(500));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (late(result.answers[i])) result.answers[i] = ask(frames[i]);
    }
    result.waited_s = waited_s();
  }
  return result;
}

PoseAnswer TransformLookup::ask(const FrameAtStamp& question) const {
  PoseAnswer answer = find(question);
  if (answer.outcome == PoseAnswer::Outcome::kFound) return answer;
  answer = explain(question);
  if (answer.outcome != PoseAnswer::Outcome::kPast) return answer;
  // It may have come between the two looks.
  const PoseAnswer again = find(question);
  return again.outcome == PoseAnswer::Outcome::kFound ? again : answer;
}

PoseAnswer TransformLookup::find(const FrameAtStamp& question) const {
  PoseAnswer answer;
  try {
    const geometry_msgs::TransformStamped found =
        buffer_.lookupTransform(reference_frame_, question.frame, question.stamp);
    answer.pose = toRigidTransform(found.transform);
    answer.outcome = PoseAnswer::Outcome::kFound;
  } catch (const tf2::TransformException&) {
    answer.outcome = PoseAnswer::Outcome::kNever;
  }
  return answer;
}

PoseAnswer TransformLookup::explain(const FrameAtStamp& question) const {
  PoseAnswer answer;
  const std::string path = "TF from '" + question.frame + "' to '" + reference_frame_ + "'";
  try {
    // The newest pose is asked for its stamp alone.
    answer.available =
        buffer_.lookupTransform(reference_frame_, question.frame, ros::Time(0)).header.stamp;
  } catch (const tf2::TransformException&) {
    answer.outcome = PoseAnswer::Outcome::kNever;
    answer.problem = path + " never seen";
    for (const std::string& frame : {question.frame, reference_frame_}) {
      if (!buffer_._frameExists(frame)) answer.problem = "TF frame '" + frame + "' never seen";
    }
    return answer;
  }
  const bool late = answer.available < question.stamp;
  answer.outcome = late ? PoseAnswer::Outcome::kLate : PoseAnswer::Outcome::kPast;
  answer.problem = path + (late ? " is late" : " no longer reaches back") + ": wanted " +
                   shown(question.stamp) + ", newest available " + shown(answer.available);
  return answer;
}

}  // namespace deformable_contact_monitor
