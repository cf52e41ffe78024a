// What a monitor's ~contact_states tell of it: how soon, how often, and how much is UNKNOWN.
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

// A message that is kept as it came: reading ten thousand states at each cycle costs more than
// the monitor's own work on them.
struct RawStates {
  std::vector<std::uint8_t> bytes;
};

// Watches in a thread of its own, from the first message on. Threads may call every function.
class StatesWatch {
 public:
  explicit StatesWatch(const std::string& monitor);

  // What came before this counts no more.
  void beginAgain();

  // A mesh with this stamp goes out now. Stamps are looked for in what comes.
  void noteSent(const ros::Time& stamp);

  // Since the last call: messages, longest silence [s], times [ms] from sending a mesh to
  // the states of its stamp.
  nlohmann::json takeLatest();

  // Of all: as above, and the share of time in which an object's pairs were UNKNOWN, the mean of
  // its pairs, by object.
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
