// What bags hold for the monitor's cycles, found in one pass before them.
#pragma once

#include <deformable_contact_monitor/LinkMeshes.h>
#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/bags/bag_reader.h"
#include "tools/bags/joint_transforms.h"
#include "tools/bags/triangles_ahead.h"

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

  struct Span {
    ros::Time first, last;  // stamps

    void add(const ros::Time& stamp);
  };

  std::map<std::string, Topic> topics;  // of the types that cycles need
  std::vector<Mesh> meshes;             // ascending stamps; equal ones in order of receipt
  // Of the whole of the bags, wherever it was recorded: /tf_static is latched, so it is sent once.
  std::vector<geometry_msgs::TransformStamped> static_transforms;
  std::map<std::string, Span> moving;          // frames whose transforms move
  std::map<std::string, std::string> parents;  // of each frame that has one, the latest
  std::map<std::string, Span> joints;          // of /joint_states
  // Poses frames that TF does not have; null: there are none, or no joints, or no URDF.
  std::shared_ptr<const JointTransforms> joint_transforms;
  TrianglesAhead triangles_ahead;
  // How far the newest stamp of a transform or a joint was ahead of a mesh's that came then, at
  // most [s].
  double transforms_ahead_s = 0;
  std::optional<LinkMeshes> link_meshes;  // the newest
  std::string robot_description;          // the newest text on a topic of that name
  std::string robot_semantic;             // on one of robot_description_semantic: the SRDF
  std::string problem;                    // why not everything could be read; empty: it was

  std::uint64_t damaged() const;
  bool hasFrame(const std::string& frame) const;
  // Frames without a parent.
  std::set<std::string> rootFrames() const;

  // Publishers start one after the other, and end so: from when on every moving frame is there that
  // comes within the first seconds, and until when all are that are there in the last ones. Zero:
  // none moves.
  ros::Time settled() const;
  ros::Time ended() const;

  // Poses by joints what TF does not have, if joints were recorded. Throws as JointTransforms does.
  void addJointTransforms(const std::string& urdf_xml);
};

// Where joints are looked for.
constexpr const char* kJointsTopic = "/joint_states";

// `progress` is called with the number of messages so far. Throws as BagReader::read does. What can
// be read before damage is kept.
BagContents scanBags(BagReader* reader, const std::function<void(std::uint64_t)>& progress);

// Whether transforms on this topic hold for ever.
bool isStatic(const std::string& topic);

}  // namespace deformable_contact_monitor
