// tf2's buffer of transforms, with what tf2 forgets of them.
#include "monitor/input/transform_buffer.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <tuple>
#include <utility>

#include "monitor/input/transform_lookup.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Returns whether tf2 accepts its names and numbers.
bool isWellFormed(const geometry_msgs::TransformStamped& transform) {
  return tf2::BufferCore().setTransform(transform, "", true);
}

// Returns whether both put the frame at the same place, but for such a difference [m], also of the
// rotations' matrices.
bool areSame(const geometry_msgs::TransformStamped& a, const geometry_msgs::TransformStamped& b,
             double tolerance) {
  if (plainFrame(a.header.frame_id) != plainFrame(b.header.frame_id)) return false;
  const RigidTransform one = toRigidTransform(a.transform), other = toRigidTransform(b.transform);
  const auto are_close = [&](double x, double y) { return std::abs(x - y) <= tolerance; };
  return std::equal(one.rotation, one.rotation + 9, other.rotation, are_close) &&
         std::equal(one.translation, one.translation + 3, other.translation, are_close);
}

// By how much places on /tf and /tf_static may differ, and those of two nodes on /tf_static:
// parameter files round numbers, such as 1.571 for pi / 2.
constexpr double kDigits = 1e-6, kFewDigits = 1e-3;

}  // namespace

bool TransformBuffer::add(const geometry_msgs::TransformStamped& transform,
                          const std::string& publisher, bool is_static, SteadyTime steady_now) {
  const ros::Time& stamp = transform.header.stamp;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!is_static && window_.isLeftover(stamp, ros_now_(), steady_now)) return false;
  const std::string frame = plainFrame(transform.child_frame_id);
  const auto known = children_.find(frame);
  const bool is_new = known == children_.end();
  if (!is_new && known->second.is_static != is_static) {
    return contest(transform, publisher, &known->second);
  }
  const bool is_accepted = setTransform(transform, publisher, is_static);
  if (!is_accepted && !isWellFormed(transform)) return false;
  Child& child = children_[frame];
  // This is done as well if tf2 rejects the transform, because it has another one with this stamp.
  if (!is_static) any_contest_ |= child.rivals.look(transform, publisher, max_gap_s_);
  if (!is_accepted) return false;
  child.is_static = is_static;
  if (is_new || is_static) child.publisher = publisher;
  if (is_static) {
    constexpr std::size_t kMostPublishers = 16;
    child.newest = child.statics[publisher] = transform;
    if (child.statics.size() > kMostPublishers) child.statics = {{publisher, transform}};
    compareStatics(&child);
  } else {
    noteStamp(transform, &child);
  }
  compareTopics(&child);
  return true;
}

// Takes a transform of the other topic than that of the frame's first one. A transform on /tf that
// equals the static one is ignored. If /tf came first, the frame is known as long as transforms on
// /tf come and equal the static one.
bool TransformBuffer::contest(const geometry_msgs::TransformStamped& transform,
                              const std::string& publisher, Child* child) {
  const auto says_so = [&](const auto& of) { return areSame(of.second, transform, kDigits); };
  if (child->is_static && std::any_of(child->statics.begin(), child->statics.end(), says_so)) {
    return true;
  }
  if (!isWellFormed(transform)) return false;
  const char* const first = child->is_static ? "/tf_static" : "/tf";
  const char* const second = child->is_static ? "/tf" : "/tf_static";
  child->contest = "TF frame '" + plainFrame(transform.child_frame_id) + "' came on " + first +
                   " (from " + child->publisher + ") and then on " + second + " (from " +
                   publisher + "), and tf2 keeps to the first: publish it on one of them, and " +
                   "restart this node";
  child->contestant = transform;
  any_contest_ = true;
  compareTopics(child);
  return false;
}

// Notes from which stamp on the two topics put the frame at different places.
void TransformBuffer::compareTopics(Child* child) {
  if (child->contest.empty() || !child->static_problem.empty()) return;
  if (areSame(child->newest, child->contestant, kDigits)) return;
  const auto& moving = child->is_static ? child->contestant : child->newest;
  const ros::Time from = std::min(moving.header.stamp, ros_now_());
  child->differ_from = std::min(child->differ_from.value_or(from), from);
}

// Finds a publisher that has the static frame elsewhere than the newest one.
void TransformBuffer::compareStatics(Child* child) {
  child->static_problem.clear();
  for (const auto& [publisher, transform] : child->statics) {
    if (areSame(transform, child->newest, kFewDigits)) continue;
    child->static_problem = "TF frame '" + plainFrame(transform.child_frame_id) + "' came on " +
                            "/tf_static from " + publisher + " and from " + child->publisher +
                            ", which put it at different places: let one of them publish it";
    any_contest_ = true;
  }
}

std::set<std::string> TransformBuffer::staticRivals() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::set<std::string> names;
  for (const auto& [frame, child] : children_) {
    if (child.static_problem.empty()) continue;
    for (const auto& of : child.statics) names.insert(of.first);
  }
  return names;
}

// If tf2 holds the transform of a dropped node, it gets that of a remaining node.
void TransformBuffer::dropStatics(const std::set<std::string>& publishers) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto& [frame, child] : children_) {
    if (child.static_problem.empty()) continue;
    auto& statics = child.statics;
    for (auto of = statics.begin(); of != statics.end();) {
      of = publishers.count(of->first) > 0 ? statics.erase(of) : std::next(of);
    }
    if (statics.empty()) statics[child.publisher] = child.newest;
    if (statics.count(child.publisher) == 0) {
      std::tie(child.publisher, child.newest) = *statics.begin();
      setTransform(child.newest, child.publisher, true);
    }
    compareStatics(&child);
    compareTopics(&child);
  }
}

// Transforms may come out of order. A late one inside a gap splits the gap in two.
void TransformBuffer::noteStamp(const geometry_msgs::TransformStamped& transform, Child* child) {
  const ros::Time& stamp = transform.header.stamp;
  const auto is_wide = [this](const ros::Time& begin, const ros::Time& end) {
    return secondsBetween(end, begin) > max_gap_s_;
  };
  std::vector<Gap>& gaps = child->gaps;
  if (stamp <= child->newest.header.stamp) {
    const auto gap = std::find_if(gaps.begin(), gaps.end(), [&](const Gap& one) {
      return one.begin < stamp && stamp < one.end;
    });
    if (gap == gaps.end()) return;
    const Gap later{stamp, gap->end};
    gap->end = stamp;
    gaps.insert(gap + 1, later);
    gaps.erase(std::remove_if(gaps.begin(), gaps.end(),
                              [&](const Gap& one) { return !is_wide(one.begin, one.end); }),
               gaps.end());
    return;
  }
  const ros::Time before = std::exchange(child->newest, transform).header.stamp;
  if (before.isZero() || !is_wide(before, stamp) || !is_wide(before, ros_now_())) return;
  const double kept_s = getCacheLength().toSec();
  gaps.erase(
      std::remove_if(gaps.begin(), gaps.end(),
                     [&](const Gap& one) { return secondsBetween(stamp, one.end) > kept_s; }),
      gaps.end());
  gaps.push_back({before, stamp});
  gaps_end_ = std::max(gaps_end_, stamp);
}

void TransformBuffer::forget(SteadyTime steady_now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  forgetLocked(steady_now);
}

// Reads the clock under the lock, so that no thread takes the time before a jump for a later one.
std::uint64_t TransformBuffer::lookAtClock(SteadyTime steady_now) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time before = std::exchange(looked_at_, ros_now_());
  if (secondsBetween(before, looked_at_) <= kClockToleranceS) return jumps_;
  forgetLocked(steady_now);
  return ++jumps_;
}

void TransformBuffer::forgetLocked(SteadyTime steady_now) {
  window_.open(steady_now);
  clear();
  for (auto& named : children_) {
    named.second.gaps.clear();
    named.second.rivals = {};
    named.second.newest.header.stamp = ros::Time();
    if (named.second.differ_from) named.second.differ_from = ros::Time();
  }
  gaps_end_ = ros::Time();
}

bool TransformBuffer::wereConnected(const std::string& frame, const std::string& other) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::set<std::string> of_other = ancestorsOf(plainFrame(other));
  const std::set<std::string> of_frame = ancestorsOf(plainFrame(frame));
  return std::any_of(of_frame.begin(), of_frame.end(),
                     [&](const std::string& name) { return of_other.count(name) > 0; });
}

// Returns the frame itself and those above it, by the newest transforms. These may make a circle,
// where a publisher has turned an edge around.
std::set<std::string> TransformBuffer::ancestorsOf(std::string frame) const {
  std::set<std::string> ancestors;
  while (!frame.empty() && ancestors.insert(frame).second) {
    const auto found = children_.find(frame);
    frame = found == children_.end() ? "" : plainFrame(found->second.newest.header.frame_id);
  }
  return ancestors;
}

std::string TransformBuffer::problemAt(const std::string& frame, const std::string& reference,
                                       const ros::Time& stamp) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!any_contest_ && stamp >= gaps_end_) return "";
  for (const std::string& name : framesBetween(frame, reference, stamp)) {
    const auto found = children_.find(name);
    if (found == children_.end()) continue;
    const Child& child = found->second;
    if (!child.static_problem.empty()) return child.static_problem;
    const bool is_contested =
        child.differ_from ? stamp >= *child.differ_from : stamp > child.newest.header.stamp;
    if (!child.contest.empty() && is_contested) return child.contest;
    std::string rivals = child.rivals.problemAt(stamp);
    if (!rivals.empty()) return rivals;
    for (const Gap& gap : child.gaps) {
      if (stamp <= gap.begin || stamp >= gap.end) continue;
      std::ostringstream text;
      text << "TF of '" << name << "' was silent for " << secondsBetween(gap.end, gap.begin)
           << " s: wanted " << stamp << ", which is between " << gap.begin << " and " << gap.end;
      return text.str();
    }
  }
  return "";
}

// Returns the frames whose transforms to their parents lie on the way from one to the other.
std::vector<std::string> TransformBuffer::framesBetween(const std::string& frame,
                                                        const std::string& reference,
                                                        const ros::Time& stamp) const {
  constexpr std::size_t kMost = 1000;  // tf2's own limit against loops
  const auto upwards = [&](const std::string& start) {
    std::vector<std::string> names{plainFrame(start)};
    std::string above;
    while (names.size() < kMost && (_getParent(names.back(), stamp, above) ||
                                    _getParent(names.back(), ros::Time(), above))) {
      names.push_back(above);
    }
    return names;
  };
  std::vector<std::string> names = upwards(frame), others = upwards(reference);
  while (!names.empty() && !others.empty() && names.back() == others.back()) {
    names.pop_back();
    others.pop_back();
  }
  names.insert(names.end(), others.begin(), others.end());
  return names;
}

}  // namespace deformable_contact_monitor
