// Subscribes to a monitor's ~contact_states, and asks a ContactReader at the present ROS time.
#pragma once

#include <ros/console.h>
#include <ros/message_event.h>
#include <ros/names.h>
#include <ros/node_handle.h>
#include <ros/param.h>
#include <ros/subscriber.h>
#include <ros/time.h>
#include <ros/transport_hints.h>

#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "reader/contact_reader.h"
#include "reader/rival_monitors.h"

namespace deformable_contact_monitor {

// Needs a spinner that runs its callback. Any thread may call any function at any time. If ROS time
// stands still, no state grows old here. A program that moves a robot in real time must therefore
// watch the clock as well, or obey contact_guard, which does.
class ContactSubscriber {
 public:
  // Subscribes to `topic`, such as "contact_monitor/contact_states". When the first states come, it
  // asks the parameter server for the monitor's margins, and warns if they are below clearance_m.
  ContactSubscriber(ros::NodeHandle node, const std::string& topic,
                    const ReaderRules& rules = ReaderRules())
      : clearance_m_(rules.clearance_m),
        reader_(rules),
        rivals_(node.resolveName(topic)),
        monitor_(ros::names::parentNamespace(node.resolveName(topic))),
        subscriber_(node.subscribe(topic, 1, &ContactSubscriber::store, this,
                                   ros::TransportHints().tcpNoDelay())) {}
  ContactSubscriber(const ContactSubscriber&) = delete;
  ContactSubscriber& operator=(const ContactSubscriber&) = delete;

  // These functions answer as those of ContactReader do.
  MoveAnswer mayMove(const std::string& body) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return reader_.mayMove(body, ros::Time::now());
  }

  NearestAnswer nearest(const std::string& body) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return reader_.nearest(body, ros::Time::now());
  }

  // Answers as ContactReader::nearestText() does, with the margins of the monitor. Asks the
  // parameter server for them, but not again within a second, below the namespace of the topic.
  std::string nearestText(const std::string& body) const {
    const std::optional<MonitorMargins> margins = readMargins();
    const std::lock_guard<std::mutex> lock(mutex_);
    return reader_.nearestText(body, ros::Time::now(), margins);
  }

  std::vector<ContactState> contacts(const std::string& body) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return reader_.contacts(body, ros::Time::now());
  }

 private:
  // Takes a message. The first one with states also tells the pairs, so it starts the check below.
  // While two nodes publish, nothing is known.
  void store(const ros::MessageEvent<const ContactStates>& event) {
    const ContactStates& states = *event.getConstMessage();
    bool is_first = false;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const std::string problem =
          rivals_.look(event.getPublisherName(), std::chrono::steady_clock::now());
      if (problem.empty()) {
        reader_.store(states, ros::Time::now());
      } else {
        reader_.forget(problem);
      }
      is_first = !margins_checked_ && !states.states.empty();
      margins_checked_ = margins_checked_ || is_first;
    }
    if (is_first && std::isfinite(clearance_m_)) checkMargins(states);
  }

  // Warns where NONE, up to the margin, lets a body move that is nearer than clearance_m.
  void checkMargins(const ContactStates& states) const {
    const std::optional<MonitorMargins> margins = readMargins();
    if (!margins) return;
    const std::string pairs =
        pairsBelow(clearance_m_, *margins, states, [](const ContactState&) { return true; });
    if (pairs.empty()) return;
    ROS_WARN_STREAM("the monitor's margin_m of "
                    << pairs << ", is below clearance_m (" << clearance_m_
                    << " m): beyond it no distance is known, and mayMove() says yes");
  }

  // Asks the master without mutex_, because that may take long. A topic in the root has been
  // remapped, and no monitor has the root's parameters.
  std::optional<MonitorMargins> readMargins() const {
    if (monitor_ == "/") return std::nullopt;
    const std::lock_guard<std::mutex> lock(margins_mutex_);
    const ros::SteadyTime now = ros::SteadyTime::now();
    if (!margins_read_.isZero() && now - margins_read_ < ros::WallDuration(1)) return margins_;
    margins_read_ = now;
    XmlRpc::XmlRpcValue parameters;
    margins_.reset();
    if (ros::param::get(monitor_, parameters)) margins_ = marginsOf(parameters);
    return margins_;
  }

  const double clearance_m_;
  mutable std::mutex mutex_;  // guards what follows
  ContactReader reader_;
  RivalMonitors rivals_;
  bool margins_checked_ = false;
  const std::string monitor_;         // its private namespace
  mutable std::mutex margins_mutex_;  // guards what follows
  mutable ros::SteadyTime margins_read_;
  mutable std::optional<MonitorMargins> margins_;
  ros::Subscriber subscriber_;
};

}  // namespace deformable_contact_monitor
