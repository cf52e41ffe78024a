// Publishes the states of one deforming object.
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/time.h>

#include <string>

#include "tools/common/scene_object.h"

namespace deformable_contact_monitor {

// Sends triangles with the first message, whenever topology_id changes, and at least once a second
// of stamps, so that a late subscriber, or one that lost a message, does not wait long.
class MeshStream {
 public:
  // `period` is the expected time between two messages.
  MeshStream(ros::NodeHandle* node, const std::string& topic, std::string object,
             std::string frame_id, ros::Duration period);

  // Publishes one state with this stamp. Vertices are in metres, in `frame_id`.
  void publish(const MeshFrame& frame, const ros::Time& stamp);

 private:
  ros::Publisher publisher_;
  std::string object_, frame_id_;
  ros::Duration period_;
  ros::Time triangles_sent_;  // stamp of the latest message with triangles; zero: none yet
  std::uint32_t topology_id_ = 0;
};

}  // namespace deformable_contact_monitor
