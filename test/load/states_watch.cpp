// Measures a monitor by its ~contact_states: latency, frequency, and the share that is UNKNOWN.
#include "states_watch.h"

#include <deformable_contact_monitor/ContactStates.h>

#include <algorithm>
#include <cstring>

namespace ros {
namespace message_traits {

using deformable_contact_monitor::ContactStates;
using deformable_contact_monitor::RawStates;

template <>
struct MD5Sum<RawStates> {
  static const char* value() { return MD5Sum<ContactStates>::value(); }
  static const char* value(const RawStates& /*message*/) { return value(); }
};

template <>
struct DataType<RawStates> {
  static const char* value() { return DataType<ContactStates>::value(); }
  static const char* value(const RawStates& /*message*/) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<deformable_contact_monitor::RawStates> {
  template <typename Stream>
  static void read(Stream& stream, deformable_contact_monitor::RawStates& message) {
    const std::uint32_t length = stream.getLength();
    message.bytes.resize(length);
    std::memcpy(message.bytes.data(), stream.advance(length), length);
  }
};

}  // namespace serialization
}  // namespace ros

namespace deformable_contact_monitor {
namespace {

template <typename Message>
void readFrom(const RawStates& raw, Message* message) {
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(raw.bytes.data()),
                                     static_cast<std::uint32_t>(raw.bytes.size()));
  ros::serialization::deserialize(stream, *message);
}

double secondsBetween(std::chrono::steady_clock::time_point from,
                      std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

StatesWatch::StatesWatch(const std::string& monitor) {
  ros::NodeHandle node;
  node.setCallbackQueue(&queue_);
  subscriber_ = node.subscribe<RawStates>(
      monitor + "/contact_states", 1000,
      [this](const boost::shared_ptr<const RawStates>& message) { receive(message); },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  spinner_.start();
}

void StatesWatch::beginAgain() {
  const std::lock_guard<std::mutex> lock(mutex_);
  all_ = latest_ = Figures();
  unknown_s_.clear();
  looked_s_ = 0;
  started_ = last_message_ = last_look_ = Clock::now();
}

void StatesWatch::noteSent(const ros::Time& stamp) {
  constexpr std::size_t kMost = 100000;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (sent_.size() > kMost) sent_.clear();
  sent_.emplace(stamp.toNSec(), Clock::now());
}

void StatesWatch::receive(const boost::shared_ptr<const RawStates>& message) {
  constexpr double kBetweenLooksS = 0.05;
  const Clock::time_point now = Clock::now();
  std_msgs::Header header;
  readFrom(*message, &header);
  bool look = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (started_ == Clock::time_point()) started_ = last_message_ = now;
    const double silence_s = secondsBetween(last_message_, now);
    last_message_ = now;
    const auto sent = sent_.find(header.stamp.toNSec());
    for (Figures* figures : {&all_, &latest_}) {
      ++figures->messages;
      figures->longest_silence_s = std::max(figures->longest_silence_s, silence_s);
      if (sent == sent_.end()) continue;
      figures->latencies_ms.push_back(static_cast<float>(1e3 * secondsBetween(sent->second, now)));
    }
    if (sent != sent_.end()) sent_.erase(sent);
    look = secondsBetween(last_look_, now) >= kBetweenLooksS;
  }
  if (look) lookAtStates(now, *message);
}

// The time since the last look counts for what is found now.
void StatesWatch::lookAtStates(Clock::time_point now, const RawStates& raw) {
  ContactStates message;
  readFrom(raw, &message);
  std::map<std::string, std::pair<double, double>> unknown_of;  // by object
  for (const ContactState& state : message.states) {
    auto& [unknown, all] = unknown_of[state.body_b];
    unknown += state.state == ContactState::UNKNOWN ? 1 : 0;
    all += 1;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  const double passed_s = last_look_ == Clock::time_point() ? 0 : secondsBetween(last_look_, now);
  last_look_ = now;
  looked_s_ += passed_s;
  for (const auto& [object, shares] : unknown_of) {
    unknown_s_[object] += passed_s * shares.first / shares.second;
  }
}

nlohmann::json StatesWatch::toJson(const Figures& figures) {
  std::vector<float> sorted = figures.latencies_ms;
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&sorted](double share) {
    const auto last = static_cast<double>(sorted.size() - 1);
    return sorted.empty() ? 0.0F : sorted[static_cast<std::size_t>(share * last)];
  };
  return {{"messages", figures.messages},
          {"with_stamp_of_a_mesh", sorted.size()},
          {"longest_silence_s", figures.longest_silence_s},
          {"p50_ms", at(0.5)},
          {"p99_ms", at(0.99)},
          {"max_ms", at(1)}};
}

nlohmann::json StatesWatch::takeLatest() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (latest_.messages == 0)
    latest_.longest_silence_s = secondsBetween(last_message_, Clock::now());
  const nlohmann::json figures = toJson(latest_);
  latest_ = Figures();
  return figures;
}

nlohmann::json StatesWatch::summary() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  nlohmann::json figures = toJson(all_);
  const Clock::time_point now = Clock::now();
  if (started_ != Clock::time_point()) {
    figures["watched_s"] = secondsBetween(started_, now);
    figures["longest_silence_s"] =
        std::max(all_.longest_silence_s, secondsBetween(last_message_, now));
  }
  for (const auto& [object, seconds] : unknown_s_) {
    figures["unknown_share"][object] = looked_s_ > 0 ? seconds / looked_s_ : 1.0;
  }
  return figures;
}

}  // namespace deformable_contact_monitor
