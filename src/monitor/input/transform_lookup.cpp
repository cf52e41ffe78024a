// Looks up poses of frames in the reference frame at a given stamp, and explains missing ones.
#include "monitor/input/transform_lookup.h"

#include <tf2/exceptions.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Returns a stamp as text, with all of its nanoseconds.
std::string shown(const ros::Time& stamp) {
  std::ostringstream text;
  text << stamp;
  return text.str();
}

// Returns the first few frames that are a prefix and the name. Only a prefix that ends with a
// separator counts, so that 'forearm' is not proposed for 'arm'.
std::vector<std::string> withPrefix(const std::vector<std::string>& frames,
                                    const std::string& name) {
  constexpr std::size_t kMost = 3;
  std::set<std::string> found;
  for (const std::string& frame : frames) {
    if (frame.size() <= name.size()) continue;
    const std::size_t length = frame.size() - name.size();
    const bool is_separated = std::isalnum(static_cast<unsigned char>(frame[length - 1])) == 0;
    if (is_separated && frame.compare(length, std::string::npos, name) == 0) found.insert(frame);
  }
  std::vector<std::string> few(found.begin(), found.end());
  few.resize(std::min(few.size(), kMost));
  return few;
}

// Returns the names in quotes.
std::string listed(const std::vector<std::string>& names, const char* between) {
  std::string text;
  for (const std::string& name : names) {
    text += text.empty() ? "" : between;
    text += "'" + name + "'";
  }
  return text;
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
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
           2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),  //
           2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)},
          {transform.translation.x, transform.translation.y, transform.translation.z}};
}

std::vector<PoseAnswer> TransformLookup::lookup(const std::vector<FrameAtStamp>& frames) const {
  std::vector<PoseAnswer> answers;
  answers.reserve(frames.size());
  for (const FrameAtStamp& frame : frames) {
    answers.push_back(ask(frame));
    if (answers.back().outcome == PoseAnswer::Outcome::kNever) {
      answers.back().problem += prefixHint(frame);
    }
  }
  return answers;
}

bool TransformLookup::isWorthWaiting(const std::vector<FrameAtStamp>& frames) const {
  return std::any_of(frames.begin(), frames.end(), [this](const FrameAtStamp& frame) {
    const PoseAnswer answer = ask(frame);
    if (answer.outcome != PoseAnswer::Outcome::kLate) return false;
    const auto given_up = given_up_.find(frame.frame);
    return given_up == given_up_.end() || given_up->second != answer.available;
  });
}

void TransformLookup::giveUp(const std::vector<FrameAtStamp>& frames) {
  for (const FrameAtStamp& frame : frames) {
    const PoseAnswer answer = ask(frame);
    if (answer.outcome == PoseAnswer::Outcome::kLate) given_up_[frame.frame] = answer.available;
  }
}

std::optional<ros::Time> TransformLookup::newestCommon(const std::vector<std::string>& frames,
                                                       double window_s, const ros::Time& now,
                                                       const ros::Time& after) const {
  std::vector<ros::Time> stamps;
  bool any = false;
  for (const std::string& frame : frames) {
    try {
      const ros::Time stamp =
          buffer_.lookupTransform(reference_frame_, frame, ros::Time(0)).header.stamp;
      any = true;
      if (!stamp.isZero()) stamps.push_back(stamp);
    } catch (const tf2::TransformException&) {  // its bodies are UNKNOWN in every cycle
    }
  }
  if (!any) return std::nullopt;
  if (stamps.empty()) return ros::Time();
  // The oldest stamp within the window: all frames that count have a pose at it.
  std::sort(stamps.begin(), stamps.end());
  const ros::Time end = now.isZero() ? stamps.back() : std::min(stamps.back(), now);
  return *std::find_if(stamps.begin(), stamps.end() - 1, [&](const ros::Time& stamp) {
    return secondsBetween(end, stamp) <= window_s && stamp > after;
  });
}

PoseAnswer TransformLookup::ask(const FrameAtStamp& question) const {
  PoseAnswer answer = find(question);
  if (answer.outcome != PoseAnswer::Outcome::kNever) return answer;
  answer = explain(question);
  if (answer.outcome == PoseAnswer::Outcome::kPast) {
    // The transform may have come between the two lookups.
    PoseAnswer again = find(question);
    if (again.outcome != PoseAnswer::Outcome::kNever) return again;
  }
  const std::string problem = problemOf(question);
  if (!problem.empty()) answer.problem = problem;
  return answer;
}

// Proposes frames that end with the names of missing ones: robots with a prefix have such frames.
std::string TransformLookup::prefixHint(const FrameAtStamp& question) const {
  const auto is_missing = [this](const std::string& frame) { return !buffer_._frameExists(frame); };
  const bool link_is_missing = !question.link.empty() && is_missing(question.frame);
  if (!link_is_missing && !is_missing(reference_frame_)) return "";
  std::vector<std::string> frames;
  buffer_._getFrameStrings(frames);
  std::string hint;
  if (is_missing(reference_frame_)) {
    const std::vector<std::string> found = withPrefix(frames, reference_frame_);
    if (!found.empty()) hint += "; there is " + listed(found, ", ") + ": set reference_frame to it";
  }
  if (link_is_missing) {
    std::vector<std::string> found = withPrefix(frames, question.link);
    if (!found.empty()) hint += "; there is " + listed(found, ", ");
    for (std::string& frame : found) frame.resize(frame.size() - question.link.size());
    if (!found.empty()) hint += ": set frame_prefix to " + listed(found, " or ");
  }
  return hint;
}

std::string TransformLookup::problemOf(const FrameAtStamp& question) const {
  return buffer_.problemAt(question.frame, reference_frame_, question.stamp);
}

PoseAnswer TransformLookup::find(const FrameAtStamp& question) const {
  PoseAnswer answer;
  const std::string before = problemOf(question);  // which may be over once the pose is found
  try {
    const geometry_msgs::TransformStamped found =
        buffer_.lookupTransform(reference_frame_, question.frame, question.stamp);
    // What spoils this pose may have come with its transform.
    answer.problem = before.empty() ? problemOf(question) : before;
    answer.outcome =
        answer.problem.empty() ? PoseAnswer::Outcome::kFound : PoseAnswer::Outcome::kPast;
    if (answer.problem.empty()) answer.pose = toRigidTransform(found.transform);
  } catch (const std::runtime_error&) {  // tf2's, or ros::Duration's if stamps are decades apart
    answer.outcome = PoseAnswer::Outcome::kNever;
  }
  return answer;
}

// Finds out why there is no pose: the newest transform decides whether the wanted one is late or
// past.
PoseAnswer TransformLookup::explain(const FrameAtStamp& question) const {
  PoseAnswer answer;
  const std::string path = "TF from '" + question.frame + "' to '" + reference_frame_ + "'";
  try {
    // The lookup at time 0 returns the newest transform; only its stamp matters here.
    answer.available =
        buffer_.lookupTransform(reference_frame_, question.frame, ros::Time(0)).header.stamp;
  } catch (const tf2::TransformException&) {
    if (buffer_.wereConnected(question.frame, reference_frame_)) {
      answer.outcome = PoseAnswer::Outcome::kLate;
      answer.problem = path + " is late: wanted " + shown(question.stamp) + ", none available yet";
      return answer;
    }
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
                   shown(question.stamp) +
                   (late ? ", newest available " : ", and all available are newer, up to ") +
                   shown(answer.available);
  return answer;
}

}  // namespace deformable_contact_monitor
