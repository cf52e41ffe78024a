// Subscriptions to meshes, with a check of each message's bytes before roscpp reads them.
#include "monitor/input/mesh_subscription.h"

#include <ros/message_event.h>
#include <ros/message_traits.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <memory>
#include <type_traits>
#include <utility>

#include "monitor/input/adapter_choice.h"
#include "monitor/input/checked_subscription.h"
#include "monitor/input/message_bytes.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Converts a message; throws if it is not a valid mesh.
template <typename M>
using Adapt = std::function<IncomingMesh(const boost::shared_ptr<const M>& message,
                                         const ros::Time& received)>;

// Returns the message's mesh, or an invalid mesh that has the message's stamp and the problem.
template <typename M>
IncomingMesh meshOf(const ros::MessageEvent<const M>& event, std::size_t max_bytes,
                    const Adapt<M>& adapt) {
  const boost::shared_ptr<const M>& message = event.getConstMessage();
  std::string problem;
  try {
    const Rejection* const rejection = boost::get_deleter<Rejection>(message);
    problem =
        rejection != nullptr ? rejection->problem : meshSizeProblem(byteCount(*message), max_bytes);
    if (problem.empty()) return adapt(message, event.getReceiptTime());
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const auto rejected = boost::make_shared<DeformableMesh>();
  const ros::Time* const stamp = ros::message_traits::timeStamp(*message);
  rejected->header.stamp = stamp != nullptr ? *stamp : event.getReceiptTime();
  return {rejected, problem};
}

// Returns the time from the receipt of a message until now [s]. roscpp notes the receipt by the
// wall clock, which somebody may set meanwhile. So a negative time, or one longer than a message
// ever waits, counts as 0. With a simulated clock the time is unknown, and 0 as well.
double waitedS(const ros::Time& receipt) {
  constexpr double kMostS = 10;
  if (ros::Time::isSimTime()) return 0;
  const ros::WallTime now = ros::WallTime::now();
  const double waited_s = secondsBetween(ros::Time(now.sec, now.nsec), receipt);
  return waited_s > 0 && waited_s < kMostS ? waited_s : 0;
}

template <typename M>
ros::SubscribeOptions subscription(const std::string& topic, std::size_t max_bytes,
                                   const MeshReceiver& receive, const Adapt<M>& adapt) {
  constexpr std::uint32_t kQueue = 1;  // only the newest message is of use
  return checkedSubscription<M>(
      topic, kQueue,
      [max_bytes](const std::uint8_t* bytes, std::size_t size) {
        return validateMeshBytes<M>(bytes, size, max_bytes);
      },
      [max_bytes, receive, adapt](const ros::MessageEvent<const M>& event) {
        IncomingMesh mesh = meshOf(event, max_bytes, adapt);
        if (mesh.message == nullptr) return;
        mesh.arrival =
            std::chrono::steady_clock::now() - fromSeconds(waitedS(event.getReceiptTime()));
        mesh.publisher = event.getPublisherName();
        // roscpp keeps one header for each connection. An adapter has one topology for all of them.
        if constexpr (std::is_same_v<M, DeformableMesh>) {
          mesh.connection = event.getConnectionHeaderPtr();
        }
        receive(mesh);
      });
}

// The adapter is shared by all copies that roscpp makes of the callback, as it remembers triangles.
template <typename Adapter>
ros::SubscribeOptions adaptedSubscription(const std::string& topic, std::size_t max_bytes,
                                          const MeshReceiver& receive, Adapter adapter) {
  using M = typename Adapter::Message;
  const auto shared = std::make_shared<Adapter>(std::move(adapter));
  return subscription<M>(topic, max_bytes, receive,
                         [shared](const boost::shared_ptr<const M>& message, const ros::Time& at) {
                           return shared->adapt(*message, at);
                         });
}

}  // namespace

// The names are in the order of MeshType.
const char* messageType(MeshType type) {
  using ros::message_traits::datatype;
  const char* const cloud = datatype<sensor_msgs::PointCloud2>();
  const char* const marker = datatype<visualization_msgs::Marker>();
  const char* const types[kMeshTypes] = {datatype<DeformableMesh>(),
                                         datatype<shape_msgs::Mesh>(),
                                         marker,
                                         cloud,
                                         datatype<visualization_msgs::MarkerArray>(),
                                         cloud,
                                         "pcl_msgs/PolygonMesh",
                                         cloud,
                                         cloud,
                                         datatype<geometry_msgs::PoseArray>(),
                                         "nav_msgs/Path",
                                         marker};
  return types[static_cast<std::size_t>(type)];
}

ros::SubscribeOptions meshSubscription(const std::string& topic, const ObjectParameters& object,
                                       std::size_t max_bytes, const MeshReceiver& receiver) {
  const MeshReceiver receive = [offset_s = object.stamp_offset_s,
                                receiver](const IncomingMesh& received) {
    IncomingMesh mesh = received;
    correctStamp(offset_s, &mesh);
    receiver(mesh);
  };
  return withAdapter(
      object,
      [&](auto adapter) {
        return adaptedSubscription(topic, max_bytes, receive, std::move(adapter));
      },
      [&] {
        return subscription<DeformableMesh>(
            topic, max_bytes, receive,
            [](const DeformableMesh::ConstPtr& message, const ros::Time& /*received*/) {
              return IncomingMesh{message};
            });
      });
}

}  // namespace deformable_contact_monitor
