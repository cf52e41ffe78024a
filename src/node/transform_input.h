// Puts transforms from /tf and /tf_static into the buffer, except those that would spoil it.
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2_msgs/TFMessage.h>

#include <string>
#include <vector>

#include "monitor/input/transform_buffer.h"

namespace deformable_contact_monitor {

// Subscribes in a thread of its own, so that transforms arrive while other callbacks are busy.
class TransformInput {
 public:
  // Fills the buffer, which must outlive this.
  TransformInput(TransformBuffer& buffer, const ros::NodeHandle& node);

  // Returns how many nodes publish on the topics, as "2 nodes publish /tf, nobody publishes
  // /tf_static". Any thread.
  std::string describePublishers() const;

  // Asks the ROS master which of the nodes whose static transforms contradict each other are still
  // there, and drops those of the others. May be called by any thread, and may take a while; throws
  // as master_watch.h says.
  void dropStaticsOfThoseGone();

 private:
  // Subscribes to a topic of transforms; a static one holds transforms without time.
  void subscribe(const std::string& topic, bool is_static);
  // Puts each transform of a message into the buffer. Runs in this class's own thread.
  void receive(const ros::MessageEvent<const tf2_msgs::TFMessage>& event, bool is_static);

  TransformBuffer& buffer_;
  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  std::vector<ros::Subscriber> subscribers_;
  ros::AsyncSpinner spinner_;
};

}  // namespace deformable_contact_monitor
