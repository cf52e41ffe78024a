// Checks the bytes of messages before roscpp reads them, and the size of those that carry a mesh.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <deformable_contact_monitor/LinkMeshes.h>
#include <deformable_contact_monitor/StatesToCheck.h>
#include <geometry_msgs/PoseArray.h>
#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/PointCloud2.h>
#include <shape_msgs/Mesh.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "monitor/input/optional_messages.h"

namespace deformable_contact_monitor {

// Returns why `size` bytes are not exactly one serialized M; empty: they are. Allocates nothing for
// what the message claims to hold. M is one of the types whose headers are included here. Any
// thread.
template <typename M>
std::string validateBytes(const std::uint8_t* bytes, std::size_t size);

// Goes with a rejected message as its deleter, so that it reaches every subscriber of this process:
// roscpp reads a message once and hands the same one to all of them.
struct Rejection {
  std::string problem;
  template <typename M>
  void operator()(const M* message) const {
    delete message;
  }
};

// Returns why a mesh of that many bytes is too large; empty: it is not.
std::string meshSizeProblem(std::uint64_t bytes, std::size_t max_bytes);

// The same for bytes that must be an M, and a mesh of at most `max_bytes`.
template <typename M>
std::string validateMeshBytes(const std::uint8_t* bytes, std::size_t size, std::size_t max_bytes) {
  const std::string problem = validateBytes<M>(bytes, size);
  return problem.empty() ? meshSizeProblem(size, max_bytes) : problem;
}

// Adds up the bytes of the fields that a message's serializer hands to it. It has 64 bits, unlike
// roscpp's own count, which wraps for a message too large to be sent.
struct ByteCounter {
  std::uint64_t bytes = 0;

  template <typename T>
  void next(const T& field) {
    if constexpr (ros::message_traits::IsMessage<T>::value) {
      ros::serialization::Serializer<T>::template allInOne<ByteCounter, const T&>(*this, field);
    } else {
      bytes += ros::serialization::serializationLength(field);
    }
  }
  template <typename T>
  void next(const std::vector<T>& fields) {
    bytes += sizeof(std::uint32_t);
    if constexpr (ros::message_traits::IsFixedSize<T>::value) {
      bytes += std::uint64_t{fields.size()} * ros::serialization::serializationLength(T());
    } else {
      for (const T& field : fields) next(field);
    }
  }
};

// Returns the bytes of a serialized message. They count against the limit where a message comes
// from the same process, and so was never serialized.
template <typename M>
std::uint64_t byteCount(const M& message) {
  ByteCounter counter;
  counter.next(message);
  return counter.bytes;
}

// Returns the stamp of the header that the bytes begin with; zero if they are too few.
ros::Time stampIn(const std::uint8_t* bytes, std::size_t size);

}  // namespace deformable_contact_monitor
