// Warnings on the console about input that is missing, refused or odd.
#pragma once

#include <ros/time.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// What is known of one object's meshes.
struct InputStatus {
  std::string object, topic;        // the topic is resolved
  std::string wanted_type;          // of its messages
  bool required = true;             // else it may be missing
  std::uint64_t received = 0;       // messages, since the start
  std::string refusal, oddity;      // of the newest; empty: none
  std::uint32_t publishers = 0;     // connected
  std::optional<std::string> type;  // that is published; nothing: none is
};

// Says what is wrong, every 5 s for as long as it is. One thread at a time. Reads no clock.
class InputWarnings {
 public:
  explicit InputWarnings(SteadyTime start) : start_(start), clock_moved_(start) {}

  // To be called about once a second; the warnings that are due, of as many lines. While ROS time
  // (`is_simulated`: that of /clock) stands still, that is the one warning about what is missing.
  std::vector<std::string> look(const std::vector<InputStatus>& inputs, const ros::Time& ros_time,
                                bool is_simulated, SteadyTime now);

 private:
  struct Watch {
    std::uint64_t received = 0;
    SteadyTime changed, due;
  };

  bool isClockSilent(const ros::Time& ros_time, bool is_simulated, SteadyTime now);
  std::string describe(const InputStatus& input, const Watch& watch, SteadyTime now) const;

  const SteadyTime start_;
  ros::Time ros_time_;
  SteadyTime clock_moved_, clock_due_;
  std::map<std::string, Watch> watches_;  // by object
};

}  // namespace deformable_contact_monitor
