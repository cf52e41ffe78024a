// From a bag's bytes to messages, every size checked before memory is asked for.
#include "tools/bags/bag_messages.h"

#include <deformable_contact_monitor/DeformableMesh.h>

#include <cstdint>
#include <stdexcept>

#include "monitor/input/wire_walker.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kOldTransforms = "tf/tfMessage";
constexpr const char* kOldTransformsMd5 = "94810edda583a504dfda3829e70d7eec";

template <typename M>
const char* typeOf() {
  return ros::message_traits::DataType<M>::value();
}

template <typename M>
const char* md5Of() {
  return ros::message_traits::MD5Sum<M>::value();
}

constexpr std::size_t kWord = sizeof(std::uint32_t);

// The overloads walk over the fields of one message type each; the second argument only selects it.
void walk(WireWalker* walker, const LinkMeshes& /*as*/) {
  walker->header();
  for (std::uint32_t left = walker->count("meshes", 4 * kWord); left > 0; --left) {
    walker->array("meshes.link", 1);
    walker->array("meshes.source", 1);
    walker->array("meshes.vertices", kWord);
    walker->array("meshes.triangles", kWord);
  }
}

void walk(WireWalker* walker, const tf2_msgs::TFMessage& /*as*/) {
  constexpr std::size_t kLeastBytes = 5 * kWord + 7 * sizeof(double);
  for (std::uint32_t left = walker->count("transforms", kLeastBytes); left > 0; --left) {
    walker->header();
    walker->array("transforms.child_frame_id", 1);
    walker->skip("transforms.transform", 7 * sizeof(double));
  }
}

void walk(WireWalker* walker, const std_msgs::String& /*as*/) { walker->array("data", 1); }

void walk(WireWalker* walker, const sensor_msgs::JointState& /*as*/) {
  walker->header();
  for (std::uint32_t left = walker->count("name", kWord); left > 0; --left) {
    walker->array("name", 1);
  }
  for (const char* field : {"position", "velocity", "effort"}) {
    walker->array(field, sizeof(double));
  }
}

template <typename M>
void decode(const BagMessage& message, M* to) {
  const bool old = message.type == kOldTransforms && message.md5 == kOldTransformsMd5;
  if (!old && message.md5 != md5Of<M>()) {
    throw std::runtime_error(message.topic + ": another version of " + message.type);
  }
  try {
    WireWalker walker(message.bytes.data(), message.bytes.size());
    walk(&walker, *to);
    if (!walker.problem().empty()) throw std::runtime_error(walker.problem());
    if (walker.left() > 0) {
      throw std::runtime_error(std::to_string(walker.left()) + " bytes follow its fields");
    }
    // IStream's argument is not const, but it only reads.
    ros::serialization::IStream stream(const_cast<std::uint8_t*>(message.bytes.data()),
                                       static_cast<std::uint32_t>(message.bytes.size()));
    ros::serialization::deserialize(stream, *to);
  } catch (const std::exception& error) {
    throw std::runtime_error(message.topic + ": a message is damaged: " + error.what());
  }
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
  tf2_msgs::TFMessage transforms;
  decode(message, &transforms);
  return transforms;
}

LinkMeshes toLinkMeshes(const BagMessage& message) {
  LinkMeshes meshes;
  decode(message, &meshes);
  return meshes;
}

std::string toText(const BagMessage& message) {
  std_msgs::String text;
  decode(message, &text);
  return text.data;
}

std_msgs::Header headerOf(const BagMessage& message) {
  std_msgs::Header header;
  // IStream's argument is not const, but it only reads, and it checks each length.
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(message.bytes.data()),
                                     static_cast<std::uint32_t>(message.bytes.size()));
  ros::serialization::deserialize(stream, header);
  return header;
}

sensor_msgs::JointState toJointState(const BagMessage& message) {
  sensor_msgs::JointState state;
  decode(message, &state);
  if (state.header.stamp.isZero()) state.header.stamp = message.received;
  return state;
}

}  // namespace deformable_contact_monitor
