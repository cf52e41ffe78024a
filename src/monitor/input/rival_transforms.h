// Notices that two nodes publish one frame on /tf, at different places.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <map>
#include <string>

#include "core/rigid_transform.h"

namespace deformable_contact_monitor {

// Where a frame is at the stamps of its transforms.
struct PoseInParent {
  std::string parent;
  RigidTransform pose;
};
using FrameTrack = std::map<ros::Time, PoseInParent>;

// Returns the transform's pose in its parent. Its names and numbers must be such that tf2 accepts
// them.
PoseInParent placeOf(const geometry_msgs::TransformStamped& transform);

// Returns whether the place contradicts the track: its stamp lies between two stamps of the track
// that are at most `longest_step_s` [s] apart, and its distance from the places at both is larger
// than the largest step of the track around that stamp. False if that is not known.
bool contradicts(const FrameTrack& track, const ros::Time& stamp, const PoseInParent& place,
                 double longest_step_s);

// The transforms of one frame. tf2 keeps those of all publishers together, and the frame jumps to
// and fro between their places. Two publishers are rivals if a transform of one contradicts the
// track of the other. So two nodes that publish the same are no rivals, and neither is a node that
// takes the place of another one. A publisher contradicts itself if it has two places for a stamp,
// as two nodelets do that share a name. One thread at a time.
class RivalTransforms {
 public:
  // Takes each transform whose names and numbers tf2 accepts, in the order of arrival. Returns
  // whether it contradicts another one. `max_gap_s`: longest step [s] across which poses are
  // interpolated.
  bool look(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
            double max_gap_s);

  // Returns which nodes contradict each other at that stamp; empty: none does.
  std::string problemAt(const ros::Time& stamp) const;

 private:
  bool compare(const FrameTrack::iterator& place, FrameTrack* track, const std::string& publisher);
  void noteRival(const std::string& publisher, const std::string& rival, const ros::Time& from,
                 const ros::Time& stamp);

  geometry_msgs::TransformStamped last_;
  std::string publisher_;  // of the last one
  // By publisher, of the last seconds, while there are several publishers.
  std::map<std::string, FrameTrack> tracks_;
  double longest_step_s_ = 0;
  std::string problem_;
  ros::Time from_, newest_;  // stamps of the first and the last contradiction
};

}  // namespace deformable_contact_monitor
