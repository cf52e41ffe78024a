// Extends tf2's buffer of transforms. It also remembers gaps, transforms from before a jump of the
// clock, and frames whose publishers contradict each other.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/steady_time.h"
#include "monitor/input/rival_transforms.h"
#include "monitor/input/usable_stamp.h"

namespace deformable_contact_monitor {

// tf2 would give a pose in four cases in which nobody knows it:
// - A transform may be on its way when the clock goes back. Arriving later, it would be stamped
//   ahead of those of the new time, and tf2 would interpolate between the two.
// - Transforms fail to come for seconds. Once they come again, tf2 interpolates across the gap.
// - A frame's first transform decides for ever whether the frame is static. If /tf_static and /tf
//   put it at different places, tf2 keeps to the topic that was first, in each node another one. If
//   that is /tf_static, it gives the newest transform for any stamp, also when the publisher is
//   gone.
// - Two nodes publish a frame at different places, on /tf (RivalTransforms) or on /tf_static. Of
//   static ones tf2 keeps the place that came last, which is another one in each node.
// Any thread may call any function. Do not call setTransform() of tf2: it skips these checks.
class TransformBuffer : public tf2::BufferCore {
 public:
  // `ros_now` returns ROS time; any thread may call it. A frame's transforms have a gap where, as
  // the next one came, the newest was more than `max_gap_s` [s] behind both of it and the clock. A
  // publisher that sends rarely but stamps ahead leaves no gap.
  explicit TransformBuffer(std::function<ros::Time()> ros_now = ros::Time::now,
                           double max_gap_s = std::numeric_limits<double>::infinity(),
                           ros::Duration cache_time = ros::Duration(DEFAULT_CACHE_TIME))
      : BufferCore(cache_time), ros_now_(std::move(ros_now)), max_gap_s_(max_gap_s) {}

  // Adds a transform, unless a jump left it behind, or it is not on the topic of its frame's first
  // one. Returns true if the frame is now where the transform puts it. Throws as setTransform() of
  // tf2 does.
  bool add(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
           bool is_static, SteadyTime steady_now);

  // Drops all transforms but the static ones, and for half a second those that come from before.
  void forget(SteadyTime steady_now);

  // Does that if the clock went back since the last call, by more than two machines may differ.
  // Returns how often it did that so far. tf2 takes no transform that is much older than its newest
  // one, so call it before add(): whoever else notices the jump may be later than the first
  // transforms of the new time.
  std::uint64_t lookAtClock(SteadyTime steady_now);

  // Returns whether the newest transforms lead from one frame to the other, whatever their stamps
  // are, also if they were forgotten since.
  bool wereConnected(const std::string& frame, const std::string& other) const;

  // Returns the nodes that put a frame at different places on /tf_static. The buffer does not know
  // which of them have ended; call dropStatics() for those.
  std::set<std::string> staticRivals() const;

  // Forgets where these nodes put frames that have several places. Of a frame that no other node
  // publishes, the place that came last remains.
  void dropStatics(const std::set<std::string>& publishers);

  // Returns why the pose of `frame` in `reference` at that stamp is not known, although tf2 may
  // give one: a frame between the two has a gap then, is on both topics, or has two publishers that
  // contradict each other. Empty: no problem is known.
  std::string problemAt(const std::string& frame, const std::string& reference,
                        const ros::Time& stamp) const;

 private:
  struct Gap {
    ros::Time begin, end;  // stamps of transforms; between them there is none
  };
  // What is known of a frame's transforms to its parent.
  struct Child {
    bool is_static = false;
    geometry_msgs::TransformStamped newest;  // by arrival if it is static, else by stamp
    std::string publisher;
    std::vector<Gap> gaps;  // of the last seconds, ascending
    std::string contest;    // says that the frame is on both topics; empty: it is not
    geometry_msgs::TransformStamped contestant;  // the newest of the other topic
    // From this stamp on, the topics differ. They agree if it is empty.
    std::optional<ros::Time> differ_from;
    RivalTransforms rivals;  // on /tf
    // On /tf_static: the newest transform of each publisher, and why they do not go together.
    std::map<std::string, geometry_msgs::TransformStamped> statics;
    std::string static_problem;
  };

  void forgetLocked(SteadyTime steady_now);
  std::set<std::string> ancestorsOf(std::string frame) const;
  bool contest(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
               Child* child);
  void compareTopics(Child* child);
  void compareStatics(Child* child);
  void noteStamp(const geometry_msgs::TransformStamped& transform, Child* child);
  std::vector<std::string> framesBetween(const std::string& frame, const std::string& reference,
                                         const ros::Time& stamp) const;

  const std::function<ros::Time()> ros_now_;
  const double max_gap_s_;
  mutable std::mutex mutex_;  // so that nothing slips in between a check and what follows from it
  ros::Time looked_at_;       // ROS time at the last lookAtClock()
  std::uint64_t jumps_ = 0;
  LeftoverWindow window_;
  std::map<std::string, Child> children_;  // by frame
  ros::Time gaps_end_;                     // no gap ends later
  bool any_contest_ = false;
};

}  // namespace deformable_contact_monitor
