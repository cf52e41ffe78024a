// Notices that two nodes publish one frame on /tf, at different places.
#include "monitor/input/rival_transforms.h"

#include <tf2/buffer_core.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "monitor/input/transform_lookup.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kRememberedS = 1;     // of each publisher, and after the last contradiction
constexpr double kLongestStepS = 0.5;  // between two transforms, which tell what is between them
constexpr double kTolerance = 1e-3;    // [m], and of the rotations' matrices

struct Distance {
  double translation = 0, rotation = 0;
};

Distance distance(const RigidTransform& a, const RigidTransform& b) {
  Distance d;
  for (int i = 0; i < 9; ++i) {
    d.rotation = std::max(d.rotation, std::abs(a.rotation[i] - b.rotation[i]));
  }
  for (int i = 0; i < 3; ++i) {
    d.translation = std::hypot(d.translation, a.translation[i] - b.translation[i]);
  }
  return d;
}

}  // namespace

// Returns whether it lies between two transforms of the track and is further from both than these
// are from one another.
bool RivalTransforms::contradicts(const Track& track, const Track::value_type& other) {
  const auto& [stamp, place] = other;
  const auto after = track.lower_bound(stamp);
  if (after == track.end()) return false;
  const auto before = after->first == stamp || after == track.begin() ? after : std::prev(after);
  if (before->first > stamp || secondsBetween(after->first, before->first) > kLongestStepS) {
    return false;
  }
  if (place.parent != before->second.parent && place.parent != after->second.parent) return true;
  const Distance step = distance(before->second.pose, after->second.pose);
  const Distance one = distance(place.pose, before->second.pose);
  const Distance two = distance(place.pose, after->second.pose);
  return std::min(one.translation, two.translation) > step.translation + kTolerance ||
         std::min(one.rotation, two.rotation) > step.rotation + kTolerance;
}

bool RivalTransforms::look(const geometry_msgs::TransformStamped& transform,
                           const std::string& publisher) {
  const auto placeOf = [](const geometry_msgs::TransformStamped& of) {
    return Place{plainFrame(of.header.frame_id), toRigidTransform(of.transform)};
  };
  if (tracks_.empty() && (publisher_.empty() || publisher == publisher_)) {
    const Distance moved = distance(placeOf(last_).pose, placeOf(transform).pose);
    const bool is_elsewhere = !publisher_.empty() && transform.header.stamp == last_.header.stamp &&
                              std::max(moved.translation, moved.rotation) > kTolerance;
    publisher_ = publisher;
    last_ = transform;
    if (is_elsewhere) noteRival(publisher, publisher, transform.header.stamp);
    return is_elsewhere;
  }
  if (!tf2::BufferCore().setTransform(transform, publisher, true)) return false;  // it is malformed
  if (tracks_.empty()) tracks_[publisher_][last_.header.stamp] = placeOf(last_);
  publisher_ = publisher;
  last_ = transform;
  const ros::Time& stamp = transform.header.stamp;
  Track& track = tracks_[publisher];
  const auto place = track.insert_or_assign(stamp, placeOf(transform)).first;
  const auto next = std::next(place);
  const auto begin = place == track.begin() ? place : std::prev(place);
  const ros::Time end = next == track.end() ? stamp : next->first;
  bool is_rival = false;
  for (auto other = tracks_.begin(); other != tracks_.end();) {
    Track& theirs = other->second;
    if (&theirs != &track) {
      bool differs = contradicts(theirs, *place);
      for (auto one = theirs.lower_bound(begin->first); one != theirs.end() && one->first <= end;
           ++one) {
        differs = differs || contradicts(track, *one);
      }
      if (differs) noteRival(publisher, other->first, std::min(begin->first, stamp));
      is_rival = is_rival || differs;
    }
    while (!theirs.empty() && secondsBetween(stamp, theirs.begin()->first) > kRememberedS) {
      theirs.erase(theirs.begin());
    }
    other = theirs.empty() ? tracks_.erase(other) : std::next(other);
  }
  if (tracks_.size() < 2) tracks_.clear();
  return is_rival;
}

void RivalTransforms::noteRival(const std::string& publisher, const std::string& rival,
                                const ros::Time& stamp) {
  from_ = problem_.empty() || stamp > until_ ? stamp : std::min(from_, stamp);
  until_ = std::max(until_, stamp + ros::Duration(kRememberedS));
  const std::string frame = "TF frame '" + plainFrame(last_.child_frame_id) + "' ";
  problem_ = publisher == rival
                 ? publisher + " publishes " + frame + "twice at one stamp, at different places"
                 : "two nodes publish " + frame +
                       "on /tf, at different places: " + std::min(publisher, rival) + " and " +
                       std::max(publisher, rival) + "; stop one of them";
}

std::string RivalTransforms::problemAt(const ros::Time& stamp) const {
  return problem_.empty() || stamp < from_ || stamp > until_ ? "" : problem_;
}

}  // namespace deformable_contact_monitor
