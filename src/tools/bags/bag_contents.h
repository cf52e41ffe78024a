// The contents of bags, as a first reading finds them: topics, meshes, transforms and the robot.
// The cycles come from a second reading, which uses what this one found.
#pragma once

#include <deformable_contact_monitor/LinkMeshes.h>
#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/bags/bag_reader.h"
#include "tools/bags/bag_topics.h"
#include "tools/bags/joint_transforms.h"
#include "tools/bags/time_jumps.h"
#include "tools/bags/triangles_ahead.h"

namespace deformable_contact_monitor {

// A value that holds from when it was received until the next one of its kind.
template <typename T>
struct Recorded {
  ros::Time received;
  T value;
};

// Values of one kind, ascending times. The first one also holds before it was received: a latched
// message is sent once, maybe before the recording began.
template <typename T>
using History = std::vector<Recorded<T>>;

struct StaticTransform {
  geometry_msgs::TransformStamped transform;
  std::string publisher;
};

// Returns the index of the value that a listener had at that time; 0 if there was none yet.
template <typename T>
std::size_t indexAt(const History<T>& history, const ros::Time& received) {
  const auto later = std::upper_bound(
      history.begin(), history.end(), received,
      [](const ros::Time& time, const Recorded<T>& recorded) { return time < recorded.received; });
  return later == history.begin() ? 0 : static_cast<std::size_t>(later - history.begin()) - 1;
}

// Link meshes as they were recorded, or why they cannot be read.
struct RecordedLinkMeshes {
  LinkMeshes message;
  std::string problem;  // empty: there is none
};

// Everything that is known after the first reading. Stamps come from the messages' headers, not
// from the time of recording, unless it says otherwise.
struct BagContents {
  struct Topic {
    std::string type;
    std::string object;  // of DeformableMesh: the object's name in the first message
    std::uint64_t messages = 0;
    std::uint64_t damaged = 0;  // messages that cannot be read
    std::string damage{};       // why the first of them cannot
    // The number of the last mesh that is a deletion, while no other mesh has followed it.
    std::optional<std::uint64_t> deletion{};
  };
  struct Mesh {
    ros::Time stamp;  // of its header; the recorder's time if that is zero
    ros::Time received;
    std::uint64_t number = 0;  // counts all meshes in order of receipt, from 0
    std::string topic;
    std::size_t part = 0;  // how often the clock had gone back
    ros::Time place;       // in the order of the part's cycles; usually the stamp
    // It is a deletion that the node would take no notice of, because a mesh follows it soon, or
    // because another deletion was there shortly before.
    bool is_passing = false;
  };

  // The first and the last of some stamps.
  struct Span {
    ros::Time first, last;

    void add(const ros::Time& stamp);
  };

  std::map<std::string, Topic> topics;  // of the types that cycles need
  RecordedTopics recorded;              // all topics of the bags
  BagTopics chosen;                     // those from which everything but meshes is read
  std::vector<Mesh> meshes;  // ascending parts and places; equal ones in order of receipt
  // Meshes with the time, the topic and the bytes of another one. Counted where there are several
  // bags, because one may be a copy.
  std::uint64_t repeated_meshes = 0;
  TimeJumps jumps;  // where the clock went back
  // The static transforms of each frame whose first transform is static, without repetitions. As in
  // tf2, such a frame stays static, whatever comes on /tf later.
  std::map<std::string, History<StaticTransform>> static_transforms;
  std::uint64_t refused_transforms = 0;        // static ones that tf2 does not accept
  std::map<std::string, Span> moving;          // the other frames
  std::map<std::string, std::string> parents;  // the latest parent of each frame
  std::map<std::string, Span> joints;          // joints with positions
  // Compute the poses of frames that TF does not have, one for each URDF. Empty if there are no
  // such frames, no joints or no URDF.
  History<std::shared_ptr<const JointTransforms>> joint_transforms;
  TrianglesAhead triangles_ahead;
  // Counts the transforms on /tf, and those of them that are far ahead of their recording.
  std::uint64_t moving_transforms = 0, transforms_far_ahead = 0;
  // The largest lead of a transform's or joint's stamp over the stamp of a mesh that was recorded
  // at the same time [s].
  double transforms_ahead_s = 0;
  // These have no repetitions.
  History<RecordedLinkMeshes> link_meshes;
  std::map<std::string, History<std::string>> robot_descriptions;  // URDFs, by topic
  std::map<std::string, std::string> robot_semantics;              // the newest SRDFs, by topic
  std::string problem;  // why the reading stopped early; empty: it did not

  // Returns whether a transform on /tf counts: the node ignores stamps from far ahead of its clock.
  // If most stamps are, it is the recorder's clock that is wrong.
  bool isUsable(const ros::Time& stamp, const ros::Time& received) const;
  // Returns the number of damaged messages on all topics.
  std::uint64_t damaged() const;
  bool hasFrame(const std::string& frame) const;
  // Returns the frames without a parent.
  std::set<std::string> rootFrames() const;

  // Return the time from which, and until which, all moving frames are known. Publishers start and
  // end one after the other: frames that start much later than the first, or end much earlier than
  // the last, do not count. Zero if no frame moves.
  ros::Time settled() const;
  ros::Time ended() const;

  // Returns whether a mesh of this stamp may lack transforms only because they were recorded later,
  // or no longer. That is so before settled(), but at most in the first second of meshes, and after
  // the newest of all transforms. It is never so in bags whose clock goes back.
  bool isAtEdge(const ros::Time& stamp) const;

  // Adds the frames that joint states and the URDFs give and TF does not have. A link's frame is
  // `frame_prefix` and its name. Throws as JointTransforms does.
  void addJointTransforms(const History<std::string>& urdfs, const std::string& frame_prefix);
};

// Reads the bags once, and keeps what comes before damage. `configured` comes from
// readBagParameters(). Calls `progress` with the number of messages so far. Throws as
// BagReader::read and chooseTopics() do.
BagContents scanBags(BagReader* reader, const BagFiles& files, const MonitorParameters& configured,
                     const std::function<void(std::uint64_t)>& progress);

// Returns a stamp as tables and messages show it: seconds with nine decimals.
std::string stampText(const ros::Time& stamp);

}  // namespace deformable_contact_monitor
