// Decides which warnings about input are due: meshes that are missing, rejected or anomalous, and a
// simulated clock that is silent.
#pragma once

#include <ros/time.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Describes what is known about one object's meshes.
struct InputStatus {
  std::string object, topic;        // the topic is resolved
  std::string wanted_type;          // of its messages
  bool required = true;             // false: it may be missing
  std::uint64_t received = 0;       // messages, since the start
  std::string refusal, anomaly;     // of the newest message; empty: none
  std::string rivals;               // what MeshInput::rivals() returns; empty: nothing
  std::uint32_t publishers = 0;     // connected
  std::optional<std::string> type;  // of the published messages, if the master knows one
};

// Describes the clock that the node runs by. roscpp reads /use_sim_time once, when the node starts.
struct ClockStatus {
  ros::Time ros_time;
  bool is_simulated = false;     // ROS time comes from /clock
  bool is_sim_time_set = false;  // /use_sim_time is true now
};

// Returns a line for each object of which no mesh has come yet: who publishes on its topic. An
// object that is not required counts only if somebody publishes it.
std::vector<std::string> missingInputs(const std::vector<InputStatus>& inputs);

// Repeats a warning every 5 s while its reason lasts. Not safe for use by several threads. Reads no
// clock.
class InputWarnings {
 public:
  explicit InputWarnings(SteadyTime start) : start_(start), clock_moved_(start) {}

  // Returns the warnings that are due, one per line. Call it about once a second. While simulated
  // time (from /clock) stands still, a warning about it replaces those about missing meshes.
  std::vector<std::string> look(const std::vector<InputStatus>& inputs, const ClockStatus& clock,
                                SteadyTime now);

 private:
  // Remembers when an object's meshes last arrived, and when its next warning may come.
  struct Watch {
    std::uint64_t received = 0;
    SteadyTime changed, due;
  };

  // Returns whether /clock has stood still for 5 s.
  bool isClockSilent(const ClockStatus& clock, SteadyTime now);
  // Returns what is wrong with the clock; empty if nothing is.
  std::string describe(const ClockStatus& clock, bool is_silent, SteadyTime now) const;
  // Returns the text of the object's warning; empty if nothing is wrong.
  std::string describe(const InputStatus& input, const Watch& watch, SteadyTime now) const;

  const SteadyTime start_;
  ros::Time ros_time_;
  SteadyTime clock_moved_, clock_due_;
  std::map<std::string, Watch> watches_;  // by object
};

}  // namespace deformable_contact_monitor
