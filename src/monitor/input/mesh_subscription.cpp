// Subscriptions to meshes that look at a message's bytes before they make a mesh of them.
#include "monitor/input/mesh_subscription.h"

#include <ros/message_event.h>
#include <ros/message_traits.h>
#include <ros/subscription_callback_helper.h>

#include <boost/make_shared.hpp>
#include <memory>
#include <stdexcept>
#include <utility>

#include "monitor/input/mesh_bytes.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Goes with a refused message, also where roscpp hands it to several subscribers of one process.
struct Refusal {
  std::string why;
  template <typename M>
  void operator()(const M* message) const {
    delete message;
  }
};

template <typename M>
using Helper = ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const M>&>;

template <typename M>
class CheckingHelper : public Helper<M> {
 public:
  CheckingHelper(std::size_t max_bytes, const std::function<void()>& expect,
                 const typename Helper<M>::Callback& callback)
      : Helper<M>(callback), max_bytes_(max_bytes), expect_(expect) {}

  // roscpp may do this for another subscriber of the process: the message carries its refusal.
  ros::VoidConstPtr deserialize(
      const ros::SubscriptionCallbackHelperDeserializeParams& params) override {
    expect_();
    std::string why = whyNoMesh<M>(params.buffer, params.length, max_bytes_);
    if (why.empty()) {
      try {
        return Helper<M>::deserialize(params);
      } catch (const std::exception& error) {  // out of memory, say
        why = error.what();
      }
    }
    const boost::shared_ptr<M> message(new M, Refusal{why});
    if (ros::Time* const stamp = ros::message_traits::timeStamp(*message)) {
      *stamp = stampIn(params.buffer, params.length);
    }
    return message;
  }

 private:
  const std::size_t max_bytes_;
  const std::function<void()> expect_;
};

// What a message becomes; throws if it is no mesh.
template <typename M>
using Adapt = std::function<ReceivedMesh(const boost::shared_ptr<const M>& message,
                                         const ros::Time& received)>;

template <typename M>
ReceivedMesh received(const ros::MessageEvent<const M>& event, std::size_t max_bytes,
                      const Adapt<M>& adapt) {
  const boost::shared_ptr<const M>& message = event.getConstMessage();
  std::string why;
  try {
    const Refusal* const refusal = boost::get_deleter<Refusal>(message);
    why = refusal != nullptr ? refusal->why : whyTooLarge(byteCount(*message), max_bytes);
    if (why.empty()) return adapt(message, event.getReceiptTime());
  } catch (const std::exception& error) {
    why = error.what();
  }
  const auto refused = boost::make_shared<DeformableMesh>();
  const ros::Time* const stamp = ros::message_traits::timeStamp(*message);
  refused->header.stamp = stamp != nullptr ? *stamp : event.getReceiptTime();
  return {refused, why};
}

// From the receipt of a message until now [s]. It is known by the clock of the wall alone, which
// somebody may set: more than a message ever waits, or less than nothing, is none.
double waitedS(const ros::Time& receipt) {
  constexpr double kMostS = 10;
  if (ros::Time::isSimTime()) return 0;
  const ros::WallTime now = ros::WallTime::now();
  const double waited_s = secondsBetween(ros::Time(now.sec, now.nsec), receipt);
  return waited_s > 0 && waited_s < kMostS ? waited_s : 0;
}

template <typename M>
ros::SubscribeOptions subscription(const std::string& topic, std::size_t max_bytes,
                                   const MeshReceiver& receive, const std::function<void()>& expect,
                                   const Adapt<M>& adapt) {
  constexpr std::uint32_t kQueue = 1;
  ros::SubscribeOptions options(topic, kQueue, ros::message_traits::md5sum<M>(),
                                ros::message_traits::datatype<M>());
  options.helper = boost::make_shared<CheckingHelper<M>>(
      max_bytes, expect, [max_bytes, receive, adapt](const ros::MessageEvent<const M>& event) {
        ReceivedMesh mesh = received(event, max_bytes, adapt);
        mesh.waited_s = waitedS(event.getReceiptTime());
        receive(mesh);
      });
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  return options;
}

template <typename Adapter>
ros::SubscribeOptions adaptedSubscription(const std::string& topic, std::size_t max_bytes,
                                          const MeshReceiver& receive,
                                          const std::function<void()>& expect, Adapter adapter) {
  using M = typename Adapter::Message;
  const auto shared = std::make_shared<Adapter>(std::move(adapter));
  return subscription<M>(topic, max_bytes, receive, expect,
                         [shared](const boost::shared_ptr<const M>& message, const ros::Time& at) {
                           return shared->adapt(*message, at);
                         });
}

}  // namespace

const char* messageType(MeshType type) {
  switch (type) {
    case MeshType::kShapeMesh:
      return ros::message_traits::datatype<shape_msgs::Mesh>();
    case MeshType::kMarker:
      return ros::message_traits::datatype<visualization_msgs::Marker>();
    case MeshType::kPointCloud:
      return ros::message_traits::datatype<sensor_msgs::PointCloud2>();
    default:
      return ros::message_traits::datatype<DeformableMesh>();
  }
}

ros::SubscribeOptions meshSubscription(const std::string& topic, const ObjectParameters& object,
                                       std::size_t max_bytes, const MeshReceiver& receive,
                                       const std::function<void()>& expect) {
  switch (object.type) {
    case MeshType::kShapeMesh:
      return adaptedSubscription(topic, max_bytes, receive, expect,
                                 ShapeMeshAdapter(object.frame_id));
    case MeshType::kMarker:
      return adaptedSubscription(topic, max_bytes, receive, expect, MarkerAdapter());
    case MeshType::kPointCloud:
      return adaptedSubscription(topic, max_bytes, receive, expect,
                                 PointCloudAdapter(object.faces));
    default:
      return subscription<DeformableMesh>(
          topic, max_bytes, receive, expect,
          [](const DeformableMesh::ConstPtr& message, const ros::Time& /*received*/) {
            return ReceivedMesh{message};
          });
  }
}

}  // namespace deformable_contact_monitor
