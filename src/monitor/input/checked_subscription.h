// Subscriptions to messages whose bytes are checked before roscpp reads them.
#pragma once

#include <ros/message_event.h>
#include <ros/message_traits.h>
#include <ros/subscribe_options.h>
#include <ros/subscription_callback_helper.h>

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <string>

#include "monitor/input/message_bytes.h"

namespace deformable_contact_monitor {

// Returns what is wrong with the bytes of a message; empty: nothing.
using BytesCheck = std::function<std::string(const std::uint8_t* bytes, std::size_t size)>;

// Replaces roscpp's reader of one message type.
template <typename M>
class CheckedReader : public ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const M>&> {
  using Base = ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const M>&>;

 public:
  CheckedReader(const BytesCheck& check, const typename Base::Callback& callback)
      : Base(callback), check_(check) {}

  // Returns the message, or an empty one that has the original's stamp and carries a Rejection.
  ros::VoidConstPtr deserialize(
      const ros::SubscriptionCallbackHelperDeserializeParams& params) override {
    std::string problem = check_(params.buffer, params.length);
    if (problem.empty()) {
      try {
        return Base::deserialize(params);
      } catch (const std::exception& error) {  // out of memory, say
        problem = error.what();
      }
    }
    const boost::shared_ptr<M> message(new M, Rejection{problem});
    if (ros::Time* const stamp = ros::message_traits::timeStamp(*message)) {
      *stamp = stampIn(params.buffer, params.length);
    }
    return message;
  }

 private:
  const BytesCheck check_;
};

// Returns the options of a subscription that calls `receive` with each message. If `check` found
// something wrong, the message is empty and carries a Rejection.
template <typename M>
ros::SubscribeOptions checkedSubscription(
    const std::string& topic, std::uint32_t queue_size, const BytesCheck& check,
    const std::function<void(const ros::MessageEvent<const M>& event)>& receive) {
  ros::SubscribeOptions options(topic, queue_size, ros::message_traits::md5sum<M>(),
                                ros::message_traits::datatype<M>());
  options.helper = boost::make_shared<CheckedReader<M>>(check, receive);
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  return options;
}

// The same, but calls `receive` with each message whose bytes are exactly one M, and `reject` with
// what is wrong with the bytes of another and who sent it. M is one of the types of
// message_bytes.h.
template <typename M>
ros::SubscribeOptions checkedSubscription(
    const std::string& topic, std::uint32_t queue_size,
    const std::function<void(const boost::shared_ptr<const M>&)>& receive,
    const std::function<void(const std::string& problem)>& reject) {
  return checkedSubscription<M>(
      topic, queue_size, validateBytes<M>,
      [receive, reject](const ros::MessageEvent<const M>& event) {
        const auto& message = event.getConstMessage();
        const Rejection* const rejection = boost::get_deleter<Rejection>(message);
        if (rejection == nullptr) return receive(message);
        reject(rejection->problem + " (from " + event.getPublisherName() + ")");
      });
}

}  // namespace deformable_contact_monitor
