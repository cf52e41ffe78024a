// Puts transforms from /tf and /tf_static into the buffer, except those that would spoil it.
#include "node/transform_input.h"

#include <ros/console.h>

#include <chrono>
#include <exception>
#include <set>
#include <string>

#include "monitor/input/usable_stamp.h"
#include "monitor/time_difference.h"
#include "node/master_watch.h"

namespace deformable_contact_monitor {

// Subscribes to both topics and starts the thread. Static transforms hold at all times, so their
// stamps are not checked.
TransformInput::TransformInput(TransformBuffer& buffer, const ros::NodeHandle& node)
    : buffer_(buffer), node_(node), spinner_(1, &queue_) {
  node_.setCallbackQueue(&queue_);
  subscribe("/tf", false);
  subscribe("/tf_static", true);
  spinner_.start();
}

void TransformInput::subscribe(const std::string& topic, bool is_static) {
  const boost::function<void(const ros::MessageEvent<const tf2_msgs::TFMessage>&)> receive =
      [this, is_static](const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
        this->receive(event, is_static);
      };
  subscribers_.push_back(node_.subscribe<tf2_msgs::TFMessage>(
      topic, 100, receive, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
}

std::string TransformInput::describePublishers() const {
  std::string text;
  for (const ros::Subscriber& subscriber : subscribers_) {
    const std::uint32_t publishers = subscriber.getNumPublishers();
    text += text.empty() ? "" : ", ";
    text += publishers == 0   ? "nobody publishes "
            : publishers == 1 ? "1 node publishes "
                              : std::to_string(publishers) + " nodes publish ";
    text += subscriber.getTopic();
  }
  return text;
}

void TransformInput::dropStaticsOfThoseGone() {
  const std::string topic = subscribers_.back().getTopic();
  std::set<std::string> gone;
  for (const std::string& node : buffer_.staticRivals()) {
    if (!mayPublish(node, topic)) gone.insert(node);
  }
  buffer_.dropStatics(gone);
}

// A transform that tf2 rejects does not affect the others of its message.
void TransformInput::receive(const ros::MessageEvent<const tf2_msgs::TFMessage>& event,
                             bool is_static) {
  const ros::Time now = ros::Time::now();
  const SteadyTime steady_now = std::chrono::steady_clock::now();
  buffer_.lookAtClock(steady_now);
  for (const geometry_msgs::TransformStamped& transform : event.getMessage()->transforms) {
    const ros::Time& stamp = transform.header.stamp;
    if (!is_static && !isUsableStamp(stamp, now)) {
      ROS_WARN_STREAM_THROTTLE(1, "the transform of '"
                                      << transform.child_frame_id << "' from "
                                      << event.getPublisherName() << " is ignored: its stamp is "
                                      << secondsBetween(stamp, now)
                                      << " s ahead of the clock; check the publisher's clock; see "
                                         "config/docs/console.md#no-transform");
      continue;
    }
    try {
      buffer_.add(transform, event.getPublisherName(), is_static, steady_now);
    } catch (const std::exception& error) {  // also of ROS time, for stamps at its end
      ROS_WARN_STREAM_THROTTLE(
          1, "a transform is rejected: " << error.what()
                                         << "; see config/docs/console.md#no-transform");
    }
  }
}

}  // namespace deformable_contact_monitor
