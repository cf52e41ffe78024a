// Notices that two nodes publish one frame on /tf, at different places.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <map>
#include <string>

#include "core/rigid_transform.h"

namespace deformable_contact_monitor {

// The transforms of one frame. tf2 keeps those of all publishers together, and the frame jumps to
// and fro between their places. Two publishers contradict each other where a transform of one,
// whose stamp is between those of two transforms of the other, is further from both than these are
// from one another. So two nodes that publish the same are no rivals, and neither is a node that
// takes the place of another one. A publisher contradicts itself if it has two places for a stamp,
// as two nodelets do that share a name. One thread at a time.
class RivalTransforms {
 public:
  // Takes each transform in the order of arrival. Returns whether it contradicts another one.
  bool look(const geometry_msgs::TransformStamped& transform, const std::string& publisher);

  // Returns which nodes contradict each other at that stamp; empty: none does.
  std::string problemAt(const ros::Time& stamp) const;

 private:
  struct Place {
    std::string parent;
    RigidTransform pose;
  };
  using Track = std::map<ros::Time, Place>;

  static bool contradicts(const Track& track, const Track::value_type& other);
  void noteRival(const std::string& publisher, const std::string& rival, const ros::Time& stamp);

  geometry_msgs::TransformStamped last_;
  std::string publisher_;                // of the last one
  std::map<std::string, Track> tracks_;  // of the last second, while there are several publishers
  std::string problem_;
  ros::Time from_, until_;  // where it holds
};

}  // namespace deformable_contact_monitor
