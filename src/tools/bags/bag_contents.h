// What bags hold for the monitor's cycles, found in one pass before them.
#pragma once

#include <deformable_contact_monitor/LinkMeshes.h>
#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/bags/bag_reader.h"

namespace deformable_contact_monitor {

struct BagContents {
  struct Topic {
    std::string type;
    std::string object;  // DeformableMesh: the name that its messages carry
    std::uint64_t messages = 0;
    std::uint64_t damaged = 0;  // of them
  };
  struct Mesh {
    ros::Time stamp;  // of its header; the time of receipt where that is zero
    ros::Time received;
    std::uint64_t number = 0;  // among all meshes that are read, in order of receipt
    std::string topic;
  };

  std::map<std::string, Topic> topics;  // of the types that cycles need
  std::vector<Mesh> meshes;             // ascending stamps; equal ones in order of receipt
  // Of the whole of the bags, wherever it was recorded: /tf_static is latched, so it is sent once.
  std::vector<geometry_msgs::TransformStamped> static_transforms;
  // Stamps of transforms that move; zero: there are none. Publishers start one after the other:
  // by `settled` every frame is there that comes within the first seconds.
  ros::Time first_transform, settled, last_transform;
  std::map<std::string, std::string> parents;  // of each frame that has one, the latest
  // How far the newest transform's stamp was ahead of a mesh's that came then, at most [s].
  double transforms_ahead_s = 0;
  std::optional<LinkMeshes> link_meshes;  // the newest
  std::string robot_description;          // the newest text on a topic of that name
  std::string robot_semantic;             // on one of robot_description_semantic: the SRDF
  std::string problem;                    // why not everything could be read; empty: it was

  std::uint64_t damaged() const;
  bool hasFrame(const std::string& frame) const;
  // Frames without a parent.
  std::set<std::string> rootFrames() const;
};

// `progress` is called with the number of messages so far. Throws as BagReader::read does. What can
// be read before damage is kept.
BagContents scanBags(BagReader* reader, const std::function<void(std::uint64_t)>& progress);

// Whether transforms on this topic hold for ever.
bool isStatic(const std::string& topic);

}  // namespace deformable_contact_monitor
