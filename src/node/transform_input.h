// Transforms from /tf and /tf_static into the buffer, but for those that would spoil it.
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Whether a transform of that stamp may go into the buffer at `now` (zero: no clock yet). tf2 keeps
// what lies within some seconds of the newest: one from far ahead would shut out all that follow.
bool isUsableStamp(const ros::Time& stamp, const ros::Time& now);

class TransformInput {
 public:
  // Fills the buffer, which must outlive this, in a thread of its own.
  TransformInput(tf2::BufferCore& buffer, const ros::NodeHandle& node);

  // Transforms from far ahead of the clock, which were left out. Any thread.
  std::uint64_t leftOut() const { return left_out_; }

 private:
  void subscribe(const std::string& topic, bool is_static);
  void receive(const ros::MessageEvent<const tf2_msgs::TFMessage>& event, bool is_static);

  tf2::BufferCore& buffer_;
  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  std::atomic<std::uint64_t> left_out_{0};
  std::vector<ros::Subscriber> subscribers_;
  ros::AsyncSpinner spinner_;
};

}  // namespace deformable_contact_monitor
