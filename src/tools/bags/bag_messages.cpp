// From a bag's bytes to messages, every size checked before memory is asked for.
#include "tools/bags/bag_messages.h"

#include <tf2/buffer_core.h>

#include <boost/make_shared.hpp>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>

#include "monitor/input/adapter_choice.h"
#include "monitor/input/mesh_subscription.h"
#include "monitor/input/message_bytes.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kOldTransforms = "tf/tfMessage";
constexpr const char* kOldTransformsMd5 = "94810edda583a504dfda3829e70d7eec";

template <typename M>
const char* typeOf() {
  return ros::message_traits::DataType<M>::value();
}

// Throws std::runtime_error unless the bytes are exactly one message of the type M.
template <typename M>
void check(const BagMessage& message) {
  const bool is_old = message.type == kOldTransforms;
  if (message.md5 != ros::message_traits::md5sum<M>() &&
      !(is_old && message.md5 == kOldTransformsMd5)) {
    throw std::runtime_error(message.topic + ": another version of " +
                             (is_old ? kOldTransforms : typeOf<M>()));
  }
  const std::string why = validateBytes<M>(message.bytes.data(), message.bytes.size());
  if (!why.empty()) throw std::runtime_error(message.topic + ": a message is damaged: " + why);
}

// Reads what the bytes begin with.
template <typename M>
void deserialize(const BagMessage& message, M* to) {
  // IStream's argument is not const, but it only reads, and it checks each length.
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(message.bytes.data()),
                                     static_cast<std::uint32_t>(message.bytes.size()));
  ros::serialization::deserialize(stream, *to);
}

// Decodes a checked message. roscpp's deserializer would allocate whatever a damaged length field
// claims, so the check comes first.
template <typename M>
boost::shared_ptr<M> decoded(const BagMessage& message) {
  check<M>(message);
  auto to = boost::make_shared<M>();
  deserialize(message, to.get());
  return to;
}

// Checks a message that begins with a header, and reads no more than its stamp.
template <typename M>
BagMeshHead stampedHead(const BagMessage& message) {
  check<M>(message);
  return {stampIn(message.bytes.data(), message.bytes.size()), nullptr, false};
}

// Converts messages of another type to DeformableMesh, as the node does. An adapter keeps state
// from message to message, such as the topology_id. A message that it rejects becomes an empty mesh
// with the reason.
template <typename Adapter>
RecordedMeshReader adaptedReader(Adapter adapter) {
  return [shared = std::make_shared<Adapter>(std::move(adapter))](const BagMessage& message) {
    const auto recorded = decoded<typename Adapter::Message>(message);
    try {
      return shared->adapt(*recorded, message.clock);
    } catch (const std::invalid_argument& refusal) {
      return IncomingMesh{boost::make_shared<DeformableMesh>(), refusal.what()};
    }
  };
}

}  // namespace

const std::set<std::string>& neededTypes() {
  static const std::set<std::string> kTypes = {typeOf<DeformableMesh>(), typeOf<LinkMeshes>(),
                                               typeOf<tf2_msgs::TFMessage>(),
                                               typeOf<std_msgs::String>(), kOldTransforms};
  return kTypes;
}

bool isTransforms(const BagMessage& message) {
  return (message.type == typeOf<tf2_msgs::TFMessage>() || message.type == kOldTransforms);
}
bool isLinkMeshes(const BagMessage& message) { return message.type == typeOf<LinkMeshes>(); }
bool isText(const BagMessage& message) { return message.type == typeOf<std_msgs::String>(); }
bool isJointState(const BagMessage& message) {
  return message.type == typeOf<sensor_msgs::JointState>();
}

tf2_msgs::TFMessage toTransforms(const BagMessage& message) {
  return std::move(*decoded<tf2_msgs::TFMessage>(message));
}

LinkMeshes toLinkMeshes(const BagMessage& message) {
  return std::move(*decoded<LinkMeshes>(message));
}

std::string toText(const BagMessage& message) {
  return std::move(decoded<std_msgs::String>(message)->data);
}

std_msgs::Header headerOf(const BagMessage& message, const ObjectParameters& object) {
  std_msgs::Header header;
  if (message.type == messageType(MeshType::kMarkerArray)) {
    const auto array = decoded<visualization_msgs::MarkerArray>(message);
    const visualization_msgs::Marker* const marker = markerOf(*array, object.marker);
    return marker == nullptr ? header : marker->header;
  }
  deserialize(message, &header);
  return header;
}

sensor_msgs::JointState toJointState(const BagMessage& message) {
  sensor_msgs::JointState state = std::move(*decoded<sensor_msgs::JointState>(message));
  if (state.header.stamp.isZero()) state.header.stamp = message.clock;
  return state;
}

bool isMesh(const BagMessage& message) {
  for (std::size_t type = 0; type < kMeshTypes; ++type) {
    if (message.type == messageType(static_cast<MeshType>(type))) return true;
  }
  return false;
}

BagMeshHead headOf(const BagMessage& message, const ObjectParameters& object) {
  using visualization_msgs::Marker;
  using visualization_msgs::MarkerArray;
  if (message.type == typeOf<DeformableMesh>()) {
    const DeformableMesh::ConstPtr mesh = decoded<DeformableMesh>(message);
    return {mesh->header.stamp, mesh, false};
  }
  if (message.type == typeOf<shape_msgs::Mesh>()) {
    check<shape_msgs::Mesh>(message);
    return {};
  }
  if (message.type == typeOf<Marker>()) {
    const boost::shared_ptr<const Marker> marker = decoded<Marker>(message);
    return {marker->header.stamp, nullptr, isDeletion(*marker)};
  }
  if (message.type == typeOf<MarkerArray>()) {
    const boost::shared_ptr<const MarkerArray> array = decoded<MarkerArray>(message);
    const Marker* const marker = markerOf(*array, object.marker);
    if (marker == nullptr) return {{}, nullptr, false, true};
    return {marker->header.stamp, nullptr, isDeletion(*marker)};
  }
#ifdef DCM_HAS_PCL_MSGS
  if (message.type == typeOf<pcl_msgs::PolygonMesh>()) {
    return stampedHead<pcl_msgs::PolygonMesh>(message);
  }
#endif
#ifdef DCM_HAS_NAV_MSGS
  if (message.type == typeOf<nav_msgs::Path>()) return stampedHead<nav_msgs::Path>(message);
#endif
  if (message.type == typeOf<geometry_msgs::PoseArray>()) {
    return stampedHead<geometry_msgs::PoseArray>(message);
  }
  return stampedHead<sensor_msgs::PointCloud2>(message);
}

bool isValid(const geometry_msgs::TransformStamped& transform) {
  return tf2::BufferCore().setTransform(transform, "bag", true);
}

RecordedMeshReader recordedMeshReader(const ObjectParameters& object) {
  RecordedMeshReader read = withAdapter(
      object, [](auto adapter) { return adaptedReader(std::move(adapter)); },
      [] {
        return RecordedMeshReader([](const BagMessage& message) {
          return IncomingMesh{decoded<DeformableMesh>(message)};
        });
      });
  return [read = std::move(read), offset_s = object.stamp_offset_s](const BagMessage& message) {
    IncomingMesh mesh = read(message);
    correctStamp(offset_s, &mesh);
    return mesh;
  };
}

}  // namespace deformable_contact_monitor
