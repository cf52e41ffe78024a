// Subscriptions to meshes that look at a message's bytes before they make a mesh of them.
#include "node/mesh_subscription.h"

#include <ros/message_traits.h>
#include <ros/subscription_callback_helper.h>

#include <boost/make_shared.hpp>
#include <cstdint>
#include <cstring>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kWord = sizeof(std::uint32_t);

// Walks over serialized fields: little endian, an array after its length.
class FieldWalk {
 public:
  FieldWalk(const std::uint8_t* bytes, std::size_t size) : next_(bytes), left_(size) {}

  std::uint32_t word(const char* field) {
    std::uint32_t value = 0;
    if (left_ < kWord) return fail(std::string("the message ends before ") + field);
    std::memcpy(&value, next_, kWord);
    skip(kWord);
    return value;
  }

  void array(const char* field, std::size_t item_bytes) {
    const std::uint64_t count = word(field);
    if (!problem_.empty()) return;
    if (count * item_bytes > left_) {
      fail(std::string(field) + " claims " + std::to_string(count * item_bytes) + " bytes, but " +
           std::to_string(left_) + " are there");
      return;
    }
    skip(count * item_bytes);
  }

  std::size_t left() const { return left_; }
  const std::string& problem() const { return problem_; }  // the first

 private:
  void skip(std::size_t bytes) {
    next_ += bytes;
    left_ -= bytes;
  }

  std::uint32_t fail(const std::string& problem) {
    if (problem_.empty()) problem_ = problem;
    left_ = 0;
    return 0;
  }

  const std::uint8_t* next_;
  std::size_t left_;
  std::string problem_;
};

std::string whyTooLarge(std::uint64_t bytes, std::size_t max_bytes) {
  if (bytes <= max_bytes) return "";
  return "the mesh has " + std::to_string(bytes) + " bytes, more than max_mesh_mib allows";
}

std::uint64_t byteCount(const DeformableMesh& message) {
  return std::uint64_t{message.header.frame_id.size()} + message.object.size() +
         kWord * (std::uint64_t{message.vertices.size()} + message.triangles.size());
}

// Goes with a refused message, also where roscpp hands it to several subscribers of one process.
struct Refusal {
  std::string why;
  void operator()(const DeformableMesh* message) const { delete message; }
};

boost::shared_ptr<DeformableMesh> refused(const ros::Time& stamp, const std::string& why) {
  boost::shared_ptr<DeformableMesh> message(new DeformableMesh, Refusal{why});
  message->header.stamp = stamp;
  return message;
}

// Zero if the bytes do not hold one.
ros::Time stampIn(const std::uint8_t* bytes, std::size_t size) {
  FieldWalk walk(bytes, size);
  walk.word("header.seq");
  const std::uint32_t sec = walk.word("header.stamp");
  const std::uint32_t nsec = walk.word("header.stamp");
  ros::Time stamp;
  if (walk.problem().empty() && nsec < 1000000000) stamp = ros::Time(sec, nsec);
  return stamp;
}

using Helper = ros::SubscriptionCallbackHelperT<const DeformableMesh::ConstPtr&>;

class CheckingHelper : public Helper {
 public:
  CheckingHelper(std::size_t max_bytes, const Callback& callback)
      : Helper(callback), max_bytes_(max_bytes) {}

  // roscpp may do this for another subscriber of the process: the message carries its refusal.
  ros::VoidConstPtr deserialize(
      const ros::SubscriptionCallbackHelperDeserializeParams& params) override {
    std::string why = whyNoMesh(params.buffer, params.length, max_bytes_);
    if (why.empty()) {
      try {
        return Helper::deserialize(params);
      } catch (const std::exception& error) {  // out of memory, say
        why = error.what();
      }
    }
    return refused(stampIn(params.buffer, params.length), why);
  }

 private:
  const std::size_t max_bytes_;
};

}  // namespace

std::string whyNoMesh(const std::uint8_t* bytes, std::size_t size, std::size_t max_bytes) {
  FieldWalk walk(bytes, size);
  walk.word("header.seq");
  walk.word("header.stamp");
  walk.word("header.stamp");
  walk.array("header.frame_id", 1);
  walk.array("object", 1);
  walk.word("topology_id");
  walk.array("vertices", kWord);
  walk.array("triangles", kWord);
  if (!walk.problem().empty()) return walk.problem();
  if (walk.left() > 0) return std::to_string(walk.left()) + " bytes follow the mesh";
  return whyTooLarge(size, max_bytes);
}

ros::SubscribeOptions meshSubscription(const std::string& topic, std::size_t max_bytes,
                                       const MeshReceiver& receive) {
  const auto callback = [max_bytes, receive](const DeformableMesh::ConstPtr& message) {
    if (const Refusal* const refusal = boost::get_deleter<Refusal>(message)) {
      receive(message, refusal->why);
      return;
    }
    const std::string why = whyTooLarge(byteCount(*message), max_bytes);
    receive(why.empty() ? message : refused(message->header.stamp, why), why);
  };
  constexpr std::uint32_t kQueue = 1;
  ros::SubscribeOptions options(topic, kQueue, ros::message_traits::md5sum<DeformableMesh>(),
                                ros::message_traits::datatype<DeformableMesh>());
  options.helper = boost::make_shared<CheckingHelper>(max_bytes, callback);
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  return options;
}

}  // namespace deformable_contact_monitor
