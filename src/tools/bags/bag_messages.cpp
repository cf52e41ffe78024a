// From a bag's bytes to messages, every size checked before memory is asked for.
#include "tools/bags/bag_messages.h"

#include <deformable_contact_monitor/DeformableMesh.h>

#include <cstring>
#include <stdexcept>

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

// Walks over serialized fields. roscpp's own reader makes room for an array before it knows whether
// the array is there.
class Walker {
 public:
  explicit Walker(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  void skip(std::uint64_t size) {
    if (size > bytes_.size() - at_) throw std::runtime_error("cut off");
    at_ += size;
  }
  std::uint32_t number() {
    skip(sizeof(std::uint32_t));
    std::uint32_t value = 0;
    std::memcpy(&value, bytes_.data() + at_ - sizeof value, sizeof value);
    return value;
  }
  void array(std::uint64_t element_size) { skip(number() * element_size); }
  void text() { array(1); }
  void header() {
    skip(12);  // seq, stamp
    text();
  }
  bool atEnd() const { return at_ == bytes_.size(); }

 private:
  const std::vector<std::uint8_t>& bytes_;
  std::size_t at_ = 0;
};

void walk(Walker* walker, const LinkMeshes& /*as*/) {
  walker->header();
  for (std::uint32_t left = walker->number(); left > 0; --left) {
    walker->text();
    walker->text();
    walker->array(4);
    walker->array(4);
  }
}

void walk(Walker* walker, const tf2_msgs::TFMessage& /*as*/) {
  for (std::uint32_t left = walker->number(); left > 0; --left) {
    walker->header();
    walker->text();
    walker->skip(7 * sizeof(double));
  }
}

void walk(Walker* walker, const std_msgs::String& /*as*/) { walker->text(); }

void walk(Walker* walker, const sensor_msgs::JointState& /*as*/) {
  walker->header();
  for (std::uint32_t left = walker->number(); left > 0; --left) walker->text();
  for (int i = 0; i < 3; ++i) walker->array(sizeof(double));  // position, velocity, effort
}

template <typename M>
void decode(const BagMessage& message, M* to) {
  const bool old = message.type == kOldTransforms && message.md5 == kOldTransformsMd5;
  if (!old && message.md5 != md5Of<M>()) {
    throw std::runtime_error(message.topic + ": another version of " + message.type);
  }
  try {
    Walker walker(message.bytes);
    walk(&walker, *to);
    if (!walker.atEnd()) throw std::runtime_error("longer than its fields");
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

sensor_msgs::JointState toJointState(const BagMessage& message) {
  sensor_msgs::JointState state;
  decode(message, &state);
  if (state.header.stamp.isZero()) state.header.stamp = message.received;
  return state;
}

}  // namespace deformable_contact_monitor
