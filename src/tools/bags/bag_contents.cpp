// What bags hold for the monitor's cycles, found in one pass before them.
#include "tools/bags/bag_contents.h"

#include <algorithm>
#include <exception>

#include "node/time_difference.h"
#include "node/transform_lookup.h"
#include "tools/bags/bag_meshes.h"
#include "tools/bags/bag_messages.h"

namespace deformable_contact_monitor {
namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

constexpr double kStartS = 5;  // of a bag: publishers that come later came late

using FirstStamps = std::map<std::string, ros::Time>;  // of each frame

void lookAtTransforms(const BagMessage& message, FirstStamps* first, BagContents* contents) {
  for (const geometry_msgs::TransformStamped& transform : toTransforms(message).transforms) {
    contents->parents[plainFrame(transform.child_frame_id)] = plainFrame(transform.header.frame_id);
    if (isStatic(message.topic)) {
      contents->static_transforms.push_back(transform);
      continue;
    }
    const ros::Time& stamp = transform.header.stamp;
    if (contents->first_transform.isZero() || stamp < contents->first_transform) {
      contents->first_transform = stamp;
    }
    contents->last_transform = std::max(contents->last_transform, stamp);
    const auto [frame, is_new] = first->emplace(transform.child_frame_id, stamp);
    if (!is_new) frame->second = std::min(frame->second, stamp);
  }
}

ros::Time settled(const FirstStamps& first, const ros::Time& start) {
  ros::Time latest = start;
  for (const auto& [frame, stamp] : first) {
    if (secondsBetween(stamp, start) <= kStartS) latest = std::max(latest, stamp);
  }
  return latest;
}

void lookAtMesh(const BagMessage& message, BagContents::Topic* topic, BagContents* contents) {
  const std::uint64_t number = contents->meshes.size();
  contents->meshes.push_back({message.received, message.received, number, message.topic});
  const BagMeshHead head = headOf(message);
  if (!head.stamp.isZero()) contents->meshes.back().stamp = head.stamp;
  if (topic->object.empty()) topic->object = head.object;
  if (contents->last_transform.isZero()) return;
  contents->transforms_ahead_s =
      std::max(contents->transforms_ahead_s,
               secondsBetween(contents->last_transform, contents->meshes.back().stamp));
}

void lookAt(const BagMessage& message, BagContents::Topic* topic, FirstStamps* first,
            BagContents* contents) {
  if (isTransforms(message)) lookAtTransforms(message, first, contents);
  if (isMesh(message)) lookAtMesh(message, topic, contents);
  if (isLinkMeshes(message)) contents->link_meshes = toLinkMeshes(message);
  if (isText(message) && endsWith(message.topic, "robot_description")) {
    contents->robot_description = toText(message);
  }
  if (isText(message) && endsWith(message.topic, "robot_description_semantic")) {
    contents->robot_semantic = toText(message);
  }
}

}  // namespace

std::uint64_t BagContents::damaged() const {
  std::uint64_t sum = 0;
  for (const auto& [name, topic] : topics) sum += topic.damaged;
  return sum;
}

bool BagContents::hasFrame(const std::string& frame) const {
  return parents.count(frame) > 0 || rootFrames().count(frame) > 0;
}

std::set<std::string> BagContents::rootFrames() const {
  std::set<std::string> roots;
  for (const auto& [frame, parent] : parents) {
    if (parents.count(parent) == 0) roots.insert(parent);
  }
  return roots;
}

bool isStatic(const std::string& topic) { return endsWith(topic, "tf_static"); }

BagContents scanBags(BagReader* reader, const std::function<void(std::uint64_t)>& progress) {
  BagContents contents;
  FirstStamps first;
  std::uint64_t count = 0;
  contents.problem = reader->read([&](const BagMessage& message) {
    progress(++count);
    BagContents::Topic& topic = contents.topics[message.topic];
    topic.type = message.type;
    ++topic.messages;
    try {
      lookAt(message, &topic, &first, &contents);
    } catch (const std::exception&) {
      ++topic.damaged;
    }
  });
  contents.settled = settled(first, contents.first_transform);
  std::sort(contents.meshes.begin(), contents.meshes.end(),
            [](const BagContents::Mesh& a, const BagContents::Mesh& b) {
              return a.stamp != b.stamp ? a.stamp < b.stamp : a.number < b.number;
            });
  return contents;
}

}  // namespace deformable_contact_monitor
