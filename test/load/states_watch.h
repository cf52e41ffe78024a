// Measures a monitor by its ~contact_states: latency, frequency, and the share that is UNKNOWN.
#pragma once

#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/spinner.h>

#include <chrono>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>
#include <vector>

namespace deformable_contact_monitor {

// A message that stays serialized. Reading ten thousand states at each cycle would cost more than
// the monitor's own work on them.
struct RawStates {
  std::vector<std::uint8_t> bytes;
};

// Receives in a thread of its own, from the first message on. Every function may be called from any
// thread.
class StatesWatch {
 public:
  explicit StatesWatch(const std::string& monitor);

  // Forgets all figures so far, such as those of warming up.
  void beginAgain();

  // Notes that a mesh with this stamp is sent now. Its latency ends with the states of that stamp.
  void noteSent(const ros::Time& stamp);

  // Returns figures since the last call: the number of messages, the longest silence [s], and the
  // latencies [ms] from sending a mesh to the states of its stamp.
  nlohmann::json takeLatest();

  // Returns the same figures since the start or beginAgain(), and for each object the share of time
  // in [0, 1] in which its pairs were UNKNOWN, as the mean of its pairs.
  nlohmann::json summary() const;

 private:
  using Clock = std::chrono::steady_clock;

  struct Figures {
    std::uint64_t messages = 0;
    double longest_silence_s = 0;
    std::vector<float> latencies_ms;
  };

  void receive(const boost::shared_ptr<const RawStates>& message);
  void lookAtStates(Clock::time_point now, const RawStates& message);
  static nlohmann::json toJson(const Figures& figures);

  mutable std::mutex mutex_;
  std::unordered_map<std::uint64_t, Clock::time_point> sent_;  // by stamp [ns]
  Clock::time_point started_, last_message_, last_look_;
  Figures all_, latest_;
  std::map<std::string, double> unknown_s_;
  double looked_s_ = 0;

  ros::CallbackQueue queue_;
  ros::Subscriber subscriber_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace deformable_contact_monitor
