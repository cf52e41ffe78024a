// Notices that two nodes publish one frame on /tf, at different places.
#include "monitor/input/rival_transforms.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "monitor/input/transform_lookup.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// [m], and of the rotations' matrices. A filter may send a stamp again with a better estimate.
constexpr double kTolerance = 1e-3, kToleranceOfRepetitions = 0.05;
// Between stamps that are farther apart than this [s], no contradiction is claimed. A publisher may
// send once a second.
constexpr double kLeastStepS = 1.1, kMostStepS = 10;

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

bool areApart(const PoseInParent& a, const PoseInParent& b, double tolerance) {
  const Distance d = distance(a.pose, b.pose);
  return a.parent != b.parent || d.translation > tolerance || d.rotation > tolerance;
}

}  // namespace

PoseInParent placeOf(const geometry_msgs::TransformStamped& transform) {
  return {plainFrame(transform.header.frame_id), toRigidTransform(transform.transform)};
}

bool contradicts(const FrameTrack& track, const ros::Time& stamp, const PoseInParent& place,
                 double longest_step_s) {
  const auto after = track.lower_bound(stamp);
  if (after == track.end()) return false;
  if (after->first == stamp) return areApart(after->second, place, kTolerance);
  if (after == track.begin()) return false;
  const auto before = std::prev(after);
  if (secondsBetween(after->first, before->first) > longest_step_s) return false;
  // A frame that turns back between two stamps moves before or after them, too.
  const bool has_before = before != track.begin(), has_after = std::next(after) != track.end();
  if (!has_before && !has_after) return false;
  Distance step;
  const auto first = has_before ? std::prev(before) : before;
  const auto last = has_after ? std::next(after) : after;
  for (auto from = first; from != last; ++from) {
    const Distance one = distance(from->second.pose, std::next(from)->second.pose);
    step.translation = std::max(step.translation, one.translation);
    step.rotation = std::max(step.rotation, one.rotation);
  }
  if (place.parent != before->second.parent && place.parent != after->second.parent) return true;
  const Distance one = distance(place.pose, before->second.pose);
  const Distance two = distance(place.pose, after->second.pose);
  return std::min(one.translation, two.translation) > step.translation + kTolerance ||
         std::min(one.rotation, two.rotation) > step.rotation + kTolerance;
}

bool RivalTransforms::look(const geometry_msgs::TransformStamped& transform,
                           const std::string& publisher, double max_gap_s) {
  const ros::Time& stamp = transform.header.stamp;
  longest_step_s_ = std::clamp(max_gap_s, kLeastStepS, kMostStepS);
  if (tracks_.empty() && (publisher_.empty() || publisher == publisher_)) {
    const bool is_twice = !publisher_.empty() && stamp == last_.header.stamp &&
                          areApart(placeOf(last_), placeOf(transform), kToleranceOfRepetitions);
    publisher_ = publisher;
    last_ = transform;
    if (is_twice) noteRival(publisher, publisher, stamp, stamp);
    return is_twice;
  }
  if (tracks_.empty()) tracks_[publisher_][last_.header.stamp] = placeOf(last_);
  publisher_ = publisher;
  last_ = transform;
  FrameTrack& track = tracks_[publisher];
  const auto place = track.insert_or_assign(stamp, placeOf(transform)).first;
  const bool is_rival = compare(place, &track, publisher);
  for (auto one = tracks_.begin(); one != tracks_.end();) {
    FrameTrack& of = one->second;
    while (!of.empty() && secondsBetween(stamp, of.begin()->first) > 3 * longest_step_s_) {
      of.erase(of.begin());
    }
    one = of.empty() ? tracks_.erase(one) : std::next(one);
  }
  if (tracks_.size() < 2) tracks_.clear();
  return is_rival;
}

// Compares a new place with the tracks of the other publishers, and their recent places with this
// publisher's track. Returns whether they differ.
bool RivalTransforms::compare(const FrameTrack::iterator& place, FrameTrack* track,
                              const std::string& publisher) {
  constexpr int kNeighbours = 2;  // on either side, as contradicts() looks at
  auto first = place, last = place;
  for (int i = 0; i < kNeighbours && first != track->begin(); ++i) --first;
  for (int i = 0; i < kNeighbours && std::next(last) != track->end(); ++i) ++last;
  bool is_rival = false;
  for (const auto& [name, theirs] : tracks_) {
    if (&theirs == track) continue;
    const auto begin = theirs.lower_bound(first->first), end = theirs.upper_bound(last->first);
    bool differs = contradicts(theirs, place->first, place->second, longest_step_s_);
    for (auto one = begin; one != end && !differs; ++one) {
      differs = contradicts(*track, one->first, one->second, longest_step_s_);
    }
    if (!differs) continue;
    is_rival = true;
    const ros::Time before = begin == theirs.begin() ? first->first : std::prev(begin)->first;
    noteRival(publisher, name, std::min(before, first->first), place->first);
  }
  return is_rival;
}

void RivalTransforms::noteRival(const std::string& publisher, const std::string& rival,
                                const ros::Time& from, const ros::Time& stamp) {
  const bool is_old = problem_.empty() || secondsBetween(from, newest_) > longest_step_s_;
  from_ = is_old ? from : std::min(from_, from);
  newest_ = is_old ? stamp : std::max(newest_, stamp);
  const std::string frame = "TF frame '" + plainFrame(last_.child_frame_id) + "' ";
  problem_ = publisher == rival
                 ? publisher + " publishes " + frame + "twice at one stamp, at different places"
                 : "two nodes publish " + frame +
                       "on /tf, at different places: " + std::min(publisher, rival) + " and " +
                       std::max(publisher, rival) + "; stop one of them";
}

std::string RivalTransforms::problemAt(const ros::Time& stamp) const {
  const bool holds = stamp >= from_ && secondsBetween(stamp, newest_) <= longest_step_s_;
  return holds ? problem_ : "";
}

}  // namespace deformable_contact_monitor
