// Notices that two nodes publish the states of one monitor, such as a nodelet beside a node.
#pragma once

#include <chrono>
#include <iterator>
#include <map>
#include <string>
#include <utility>

namespace deformable_contact_monitor {

// The states of two monitors contradict one another, and nobody knows which of them is right. One
// thread at a time.
class RivalMonitors {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // `topic` is what the states are published on.
  explicit RivalMonitors(std::string topic) : topic_(std::move(topic)) {}

  // Notes that the node `publisher` sent a message, which arrived at `now`. Returns which two nodes
  // publish; empty: it is this one alone.
  std::string look(const std::string& publisher, Time now) {
    heard_[publisher] = now;
    for (auto one = heard_.begin(); one != heard_.end();) {
      one = now - one->second > kGoneAfter ? heard_.erase(one) : std::next(one);
    }
    if (heard_.size() == 1) return "";
    return "two nodes publish " + topic_ + ": " + heard_.begin()->first + " and " +
           std::next(heard_.begin())->first + "; stop one of them";
  }

  // Returns whether two nodes published when look() was called last.
  bool areThere() const { return heard_.size() > 1; }

 private:
  // A monitor may publish only once a second. So one that was silent for so long is gone.
  static constexpr std::chrono::seconds kGoneAfter{2};

  const std::string topic_;
  std::map<std::string, Time> heard_;  // when the last message of each node arrived
};

}  // namespace deformable_contact_monitor
