// The order of messages in a bag whose recorder's clock went back, as with `rosbag record` and
// /use_sim_time when a simulator starts anew.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

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

// Returns whether a frame is elsewhere in a later part than in the parts before, at the times that
// both have: in most of its transforms there. Else two recordings of the same were merged.
bool areOfSeveralEpisodes(const std::vector<std::vector<geometry_msgs::TransformStamped>>& parts);

}  // namespace deformable_contact_monitor
