// A message of any type as rosbag writes it, from bytes that need not be one.
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <ros/time.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {

struct RecordedBytes {
  std::string type, md5, definition;
  std::vector<std::uint8_t> bytes;
};

template <typename M>
RecordedBytes recordedAs(std::vector<std::uint8_t> bytes) {
  using namespace ros::message_traits;
  return {datatype<M>(), md5sum<M>(), definition<M>(), std::move(bytes)};
}

}  // namespace deformable_contact_monitor

namespace ros {
namespace message_traits {

using deformable_contact_monitor::RecordedBytes;

template <>
struct IsMessage<RecordedBytes> : TrueType {};
template <>
struct MD5Sum<RecordedBytes> {
  static const char* value(const RecordedBytes& message) { return message.md5.c_str(); }
};
template <>
struct DataType<RecordedBytes> {
  static const char* value(const RecordedBytes& message) { return message.type.c_str(); }
};
template <>
struct Definition<RecordedBytes> {
  static const char* value(const RecordedBytes& message) { return message.definition.c_str(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<deformable_contact_monitor::RecordedBytes> {
  using Message = deformable_contact_monitor::RecordedBytes;

  template <typename Stream>
  static void write(Stream& stream, const Message& message) {
    const auto size = static_cast<std::uint32_t>(message.bytes.size());
    if (size > 0) std::memcpy(stream.advance(size), message.bytes.data(), size);
  }
  static std::uint32_t serializedLength(const Message& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};

}  // namespace serialization
}  // namespace ros
