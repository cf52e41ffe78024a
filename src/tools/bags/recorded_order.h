// The order of messages in a bag whose recorder's clock went back, as with `rosbag record` and
// /use_sim_time when a simulator starts anew.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "monitor/input/rival_transforms.h"

namespace deformable_contact_monitor {

// A message of a bag, by the number of its connection and its rank in rosbag's view of that.
struct OrderedMessage {
  std::uint32_t connection = 0;
  std::size_t rank = 0;
  ros::Time received;  // rises: where the clock went back, it goes on from where it was
};

// Returns whether the messages of a connection, whose times fell to those that it had already,
// contradict one another. `parts[rank]` is how often they had fallen before the message of that
// rank.
using Contradicts =
    std::function<bool(std::uint32_t connection, const std::vector<std::size_t>& parts)>;

// Returns the messages of these connections in the order in which they were recorded, if the times
// of a connection go back in the file, and to times that it has had already, and if the connection
// is decisive or contradicts itself. Otherwise returns nothing: messages may be written in any
// order, and then their times tell. Throws std::runtime_error if the bag's records do not fit
// together.
std::vector<OrderedMessage> recordedOrder(const std::string& path,
                                          const std::set<std::uint32_t>& connections,
                                          const std::set<std::uint32_t>& decisive,
                                          const Contradicts& contradicts);

// Tells episodes from two recordings of the same that were merged: in episodes, a frame is
// elsewhere at the stamps that both have. Takes the transforms of one connection, part by part.
class EpisodesOfTransforms {
 public:
  void beginPart();
  void add(const geometry_msgs::TransformStamped& transform);
  bool found() const { return differences_ >= kFewest; }

 private:
  static constexpr int kFewest = 5;  // transforms; one of them may be wrong
  static constexpr double kLongestStepS = 1.1;
  static constexpr std::size_t kMost = 1000000;  // of places that are kept, about 300 MB

  std::map<std::string, FrameTrack> earlier_, current_;  // by frame
  int differences_ = 0;
  std::size_t stored_ = 0;
};

}  // namespace deformable_contact_monitor
