// Recorded messages of objects' types as meshes.
#include "tools/bags/bag_meshes.h"

#include <boost/make_shared.hpp>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "monitor/input/mesh_bytes.h"
#include "monitor/input/mesh_subscription.h"

namespace deformable_contact_monitor {
namespace {

// Throws std::runtime_error unless the bytes are exactly one message of the type M.
template <typename M>
void check(const BagMessage& message) {
  if (message.md5 != ros::message_traits::md5sum<M>()) {
    throw std::runtime_error(message.topic + ": another version of " +
                             ros::message_traits::datatype<M>());
  }
  const std::string why = validateMeshBytes<M>(message.bytes.data(), message.bytes.size(),
                                               std::numeric_limits<std::size_t>::max());
  if (!why.empty()) throw std::runtime_error(message.topic + ": a message is damaged: " + why);
}

// Decodes a checked message. roscpp's deserializer would allocate whatever a damaged length field
// claims, so the check comes first.
template <typename M>
boost::shared_ptr<const M> decoded(const BagMessage& message) {
  check<M>(message);
  const auto mesh = boost::make_shared<M>();
  // IStream's argument is not const, but it only reads.
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(message.bytes.data()),
                                     static_cast<std::uint32_t>(message.bytes.size()));
  ros::serialization::deserialize(stream, *mesh);
  return mesh;
}

// Converts messages of another type to DeformableMesh, as the node does. An adapter keeps state
// from message to message, such as the topology_id. A message that it rejects becomes an empty mesh
// with the reason.
template <typename Adapter>
RecordedMeshReader adaptedReader(Adapter adapter) {
  return [shared = std::make_shared<Adapter>(std::move(adapter))](const BagMessage& message) {
    const auto recorded = decoded<typename Adapter::Message>(message);
    try {
      return shared->adapt(*recorded, message.received);
    } catch (const std::invalid_argument& refusal) {
      return IncomingMesh{boost::make_shared<DeformableMesh>(), refusal.what()};
    }
  };
}

}  // namespace

bool isMesh(const BagMessage& message) {
  for (const MeshType type : {MeshType::kDeformableMesh, MeshType::kShapeMesh, MeshType::kMarker,
                              MeshType::kPointCloud}) {
    if (message.type == messageType(type)) return true;
  }
  return false;
}

BagMeshHead headOf(const BagMessage& message) {
  if (message.type == messageType(MeshType::kDeformableMesh)) {
    const DeformableMesh::ConstPtr mesh = decoded<DeformableMesh>(message);
    return {mesh->header.stamp, mesh, false};
  }
  if (message.type == messageType(MeshType::kShapeMesh)) {
    check<shape_msgs::Mesh>(message);
    return {};
  }
  if (message.type == messageType(MeshType::kMarker)) {
    using visualization_msgs::Marker;
    const boost::shared_ptr<const Marker> marker = decoded<Marker>(message);
    const bool is_deletion =
        marker->action == Marker::DELETE || marker->action == Marker::DELETEALL;
    return {marker->header.stamp, nullptr, is_deletion};
  }
  check<sensor_msgs::PointCloud2>(message);
  return {stampIn(message.bytes.data(), message.bytes.size()), nullptr, false};
}

RecordedMeshReader recordedMeshReader(const ObjectParameters& object) {
  switch (object.type) {
    case MeshType::kShapeMesh:
      return adaptedReader(ShapeMeshAdapter(object.frame_id));
    case MeshType::kMarker:
      return adaptedReader(MarkerAdapter());
    case MeshType::kPointCloud:
      return adaptedReader(PointCloudAdapter(object.faces));
    default:
      return
          [](const BagMessage& message) { return IncomingMesh{decoded<DeformableMesh>(message)}; };
  }
}

}  // namespace deformable_contact_monitor
