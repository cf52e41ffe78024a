// Subscriptions to messages whose bytes are checked before roscpp reads them.
#pragma once

#include <ros/message_traits.h>
#include <ros/subscribe_options.h>
#include <ros/subscription_callback_helper.h>

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

#include "monitor/input/message_bytes.h"

namespace deformable_contact_monitor {

// Replaces roscpp's reader of one message type. roscpp logs what deserialize() throws as an error,
// with the publisher's name, and drops the message.
template <typename M>
class CheckedReader : public ros::SubscriptionCallbackHelperT<const boost::shared_ptr<const M>&> {
  using Base = ros::SubscriptionCallbackHelperT<const boost::shared_ptr<const M>&>;

 public:
  using Base::Base;

  ros::VoidConstPtr deserialize(
      const ros::SubscriptionCallbackHelperDeserializeParams& params) override {
    const std::string problem = validateBytes<M>(params.buffer, params.length);
    if (!problem.empty()) throw std::runtime_error(problem);
    return Base::deserialize(params);
  }
};

// Returns the options of a subscription that calls `receive` with each message whose bytes are
// exactly one M. M is one of the types of message_bytes.h.
template <typename M>
ros::SubscribeOptions checkedSubscription(
    const std::string& topic, std::uint32_t queue_size,
    const std::function<void(const boost::shared_ptr<const M>&)>& receive) {
  ros::SubscribeOptions options(topic, queue_size, ros::message_traits::md5sum<M>(),
                                ros::message_traits::datatype<M>());
  options.helper = boost::make_shared<CheckedReader<M>>(receive);
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  return options;
}

}  // namespace deformable_contact_monitor
