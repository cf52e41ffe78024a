// What bags hold for the monitor's cycles, found in one pass before them.
#include "tools/bags/bag_contents.h"

#include <algorithm>
#include <exception>

#include "monitor/input/transform_lookup.h"
#include "monitor/time_difference.h"
#include "tools/bags/bag_meshes.h"
#include "tools/bags/bag_messages.h"

namespace deformable_contact_monitor {
namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// Of a bag, at its start and at its end: publishers that come later came late, and those that are
// gone before did not end with it.
constexpr double kEdgeS = 5;

void lookAtTransforms(const BagMessage& message, ros::Time* newest, BagContents* contents) {
  for (const geometry_msgs::TransformStamped& transform : toTransforms(message).transforms) {
    const std::string frame = plainFrame(transform.child_frame_id);
    contents->parents[frame] = plainFrame(transform.header.frame_id);
    if (isStatic(message.topic)) {
      contents->static_transforms.push_back(transform);
      continue;
    }
    contents->moving[frame].add(transform.header.stamp);
    *newest = std::max(*newest, transform.header.stamp);
  }
}

void lookAtJoints(const BagMessage& message, ros::Time* newest, BagContents* contents) {
  const sensor_msgs::JointState state = toJointState(message);
  for (const auto& [joint, position] : positionsIn(state)) {
    contents->joints[joint].add(state.header.stamp);
  }
  *newest = std::max(*newest, state.header.stamp);
}

void lookAtMesh(const BagMessage& message, const ros::Time& newest, BagContents::Topic* topic,
                BagContents* contents) {
  const std::uint64_t number = contents->meshes.size();
  contents->meshes.push_back({message.received, message.received, number, message.topic});
  const BagMeshHead head = headOf(message);
  ros::Time& stamp = contents->meshes.back().stamp;
  if (!head.stamp.isZero()) stamp = head.stamp;
  if (head.mesh) {
    const std::string& object = head.mesh->object;
    if (topic->object.empty()) topic->object = object;
    contents->triangles_ahead.add(message.topic + '\n' + object, number, stamp, head.mesh);
  }
  if (newest.isZero()) return;
  contents->transforms_ahead_s =
      std::max(contents->transforms_ahead_s, secondsBetween(newest, stamp));
}

void lookAt(const BagMessage& message, ros::Time* newest, BagContents::Topic* topic,
            BagContents* contents) {
  if (isTransforms(message)) lookAtTransforms(message, newest, contents);
  if (isJointState(message)) lookAtJoints(message, newest, contents);
  if (isMesh(message)) lookAtMesh(message, *newest, topic, contents);
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

void BagContents::Span::add(const ros::Time& stamp) {
  if (first.isZero() || stamp < first) first = stamp;
  last = std::max(last, stamp);
}

ros::Time BagContents::settled() const {
  ros::Time start, latest;
  for (const auto& [frame, span] : moving) {
    if (start.isZero() || span.first < start) start = span.first;
  }
  for (const auto& [frame, span] : moving) {
    if (secondsBetween(span.first, start) <= kEdgeS) latest = std::max(latest, span.first);
  }
  return latest;
}

ros::Time BagContents::ended() const {
  ros::Time end;
  for (const auto& [frame, span] : moving) end = std::max(end, span.last);
  ros::Time earliest = end;
  for (const auto& [frame, span] : moving) {
    if (secondsBetween(end, span.last) <= kEdgeS) earliest = std::min(earliest, span.last);
  }
  return earliest;
}

void BagContents::addJointTransforms(const std::string& urdf_xml) {
  if (joints.empty()) return;
  const auto is_missing = [this](const std::string& frame) { return parents.count(frame) == 0; };
  const auto made = std::make_shared<const JointTransforms>(urdf_xml, is_missing);
  for (const geometry_msgs::TransformStamped& transform : made->fixed()) {
    static_transforms.push_back(transform);
    parents[transform.child_frame_id] = transform.header.frame_id;
  }
  for (const JointTransforms::Moving& of : made->moving()) {
    const auto joint = joints.find(of.joint);
    if (joint == joints.end()) continue;
    moving[of.frame] = joint->second;
    parents[of.frame] = of.parent;
  }
  if (!made->fixed().empty() || !made->moving().empty()) joint_transforms = made;
}

bool isStatic(const std::string& topic) { return endsWith(topic, "tf_static"); }

BagContents scanBags(BagReader* reader, const std::function<void(std::uint64_t)>& progress) {
  BagContents contents;
  ros::Time newest;  // stamp of a transform or a joint
  std::uint64_t count = 0;
  contents.problem = reader->read([&](const BagMessage& message) {
    progress(++count);
    BagContents::Topic& topic = contents.topics[message.topic];
    topic.type = message.type;
    ++topic.messages;
    try {
      lookAt(message, &newest, &topic, &contents);
    } catch (const std::exception&) {
      ++topic.damaged;
    }
  });
  contents.triangles_ahead.settle();
  std::sort(contents.meshes.begin(), contents.meshes.end(),
            [](const BagContents::Mesh& a, const BagContents::Mesh& b) {
              return a.stamp != b.stamp ? a.stamp < b.stamp : a.number < b.number;
            });
  return contents;
}

}  // namespace deformable_contact_monitor
