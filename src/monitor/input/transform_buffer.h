// tf2's buffer of transforms, without those that a jump of the clock left behind.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <functional>
#include <mutex>
#include <string>
#include <utility>

#include "core/steady_time.h"
#include "monitor/input/usable_stamp.h"

namespace deformable_contact_monitor {

// A transform may be on its way when the clock goes back. Arriving later, it would be stamped ahead
// of those of the new time, and tf2 would interpolate between the two, where it should answer that
// the newest transform is not there yet. Any thread may call any function.
class TransformBuffer : public tf2::BufferCore {
 public:
  // `ros_now` returns ROS time; any thread may call it.
  explicit TransformBuffer(std::function<ros::Time()> ros_now = ros::Time::now)
      : ros_now_(std::move(ros_now)) {}

  // Adds a transform, unless a jump left it behind. Returns whether the buffer has it now. Throws
  // as setTransform() of tf2 does.
  bool add(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
           bool is_static, SteadyTime steady_now) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!is_static && window_.isLeftover(transform.header.stamp, ros_now_(), steady_now)) {
      return false;
    }
    return setTransform(transform, publisher, is_static);
  }

  // Drops all transforms but the static ones, and for half a second those that come from before.
  void forget(SteadyTime steady_now) {
    const std::lock_guard<std::mutex> lock(mutex_);
    window_.open(steady_now);
    clear();
  }

 private:
  const std::function<ros::Time()> ros_now_;
  std::mutex mutex_;  // so that nothing slips in between the check and clear()
  LeftoverWindow window_;
};

}  // namespace deformable_contact_monitor
