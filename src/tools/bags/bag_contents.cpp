// Reads bags once, and notes what the cycles need to know in advance.
#include "tools/bags/bag_contents.h"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "monitor/input/transform_lookup.h"
#include "monitor/input/usable_stamp.h"
#include "monitor/time_difference.h"
#include "tools/bags/bag_messages.h"
#include "tools/common/formatted.h"

namespace deformable_contact_monitor {
namespace {

// Publishers that start within this time of the first belong to the start of the recording, and
// those that end within it of the last belong to its end [s].
constexpr double kEdgeS = 5;

// Adds a value unless it equals the newest one, because latched messages are often sent again.
template <typename T, typename Same>
void addChange(const ros::Time& received, T value, const Same& same, History<T>* history) {
  if (!history->empty() && same(history->back().value, value)) return;
  history->push_back({received, std::move(value)});
}

// Adds a static transform, unless tf2 would refuse it. Its stamp has no meaning.
void addStatic(const ros::Time& received, const geometry_msgs::TransformStamped& transform,
               const std::string& publisher, BagContents* contents) {
  if (!isValid(transform)) {
    ++contents->refused_transforms;
    return;
  }
  const auto same = [](const StaticTransform& a, const StaticTransform& b) {
    return a.transform.header.frame_id == b.transform.header.frame_id &&
           a.transform.transform == b.transform.transform;
  };
  addChange(received, StaticTransform{transform, publisher}, same,
            &contents->static_transforms[plainFrame(transform.child_frame_id)]);
}

// The first reading keeps this until its end.
struct Scan {
  std::map<std::string, ObjectParameters> objects;  // the configured ones by topic
  ros::Time newest;                                 // stamp of a transform or a joint
  std::map<std::string, BagMessage> last_meshes;    // by topic
};

// Takes the stamp of a source. What was before the clock went back does not count in any span.
TimeJumps::Fit lookAtStamp(const std::string& source, TimeJumps::Kind kind, const ros::Time& stamp,
                           const ros::Time& received, BagContents* contents) {
  const std::size_t jumps = contents->jumps.all().size();
  const TimeJumps::Fit fit = contents->jumps.look(source, kind, stamp, received);
  if (contents->jumps.all().size() > jumps) {
    for (auto& [frame, of] : contents->moving) of = {};
    for (auto& [joint, of] : contents->joints) of = {};
  }
  return fit;
}

// Adds the stamp of a transform or joint to a span, unless it is odd.
void addMoving(const std::string& source, const ros::Time& stamp, const ros::Time& received,
               BagContents::Span* span, Scan* scan, BagContents* contents) {
  const TimeJumps::Fit fit = lookAtStamp(source, TimeJumps::Kind::kPose, stamp, received, contents);
  if (fit == TimeJumps::Fit::kOdd) return;
  if (fit == TimeJumps::Fit::kAnew) {
    *span = {};
    scan->newest = stamp;
  }
  span->add(stamp);
  scan->newest = std::max(scan->newest, stamp);
}

// Notes frames, parents and stamps.
void lookAtTransforms(const BagMessage& message, Scan* scan, BagContents* contents) {
  for (const geometry_msgs::TransformStamped& transform : toTransforms(message).transforms) {
    const std::string frame = plainFrame(transform.child_frame_id);
    contents->parents[frame] = plainFrame(transform.header.frame_id);
    if (isStatic(message.topic) && contents->moving.count(frame) == 0) {
      addStatic(message.received, transform, message.publisher, contents);
    } else if (contents->static_transforms.count(frame) == 0) {
      ++contents->moving_transforms;
      contents->transforms_far_ahead += !isUsableStamp(transform.header.stamp, message.received);
      addMoving(frameSource(frame), transform.header.stamp, message.received,
                &contents->moving[frame], scan, contents);
    }
  }
}

// Notes the stamps of each joint's positions.
void lookAtJoints(const BagMessage& message, Scan* scan, BagContents* contents) {
  const sensor_msgs::JointState state = toJointState(message);
  for (const auto& [joint, position] : positionsIn(state)) {
    addMoving(jointSource(joint), state.header.stamp, message.received, &contents->joints[joint],
              scan, contents);
  }
}

// Notes which deletions have no effect. An object keeps its mesh for kDeletionGraceS.
void lookAtDeletion(bool is_deletion, BagContents::Topic* topic, BagContents* contents) {
  BagContents::Mesh& mesh = contents->meshes.back();
  const auto of_topic = std::exchange(topic->deletion, std::nullopt);
  if (is_deletion) topic->deletion = mesh.number;
  if (!of_topic) return;
  BagContents::Mesh& deleted = contents->meshes[*of_topic];
  if (secondsBetween(mesh.received, deleted.received) > kDeletionGraceS) return;
  (is_deletion ? mesh : deleted).is_passing = true;
  if (is_deletion) topic->deletion = of_topic;
}

// Notes a mesh. A message that cannot be read stays in the list, so that the numbers of meshes are
// the same in both readings.
void lookAtMesh(const BagMessage& message, Scan* scan, BagContents::Topic* topic,
                BagContents* contents) {
  const std::uint64_t number = contents->meshes.size();
  // The mesh gets its place in the list before it is decoded, which may throw.
  contents->meshes.push_back(
      {message.clock, message.received, number, message.topic, 0, {}, false});
  const ObjectParameters& object = scan->objects[message.topic];
  const BagMeshHead head = headOf(message, object);
  ros::Time& stamp = contents->meshes.back().stamp;
  if (!head.stamp.isZero()) stamp = head.stamp;
  const ros::Time corrected = correctedStamp(stamp, object.stamp_offset_s);
  if (!corrected.isZero()) stamp = corrected;
  if (head.says_nothing) return;
  lookAtStamp(topicSource(message.topic), TimeJumps::Kind::kMesh, stamp, message.received,
              contents);
  lookAtDeletion(head.is_deletion, topic, contents);
  if (head.mesh) {
    const std::string& object = head.mesh->object;
    if (topic->object.empty()) topic->object = object;
    contents->triangles_ahead.add(message.topic + '\n' + object, number, stamp, head.mesh);
  }
  if (scan->newest.isZero()) return;
  contents->transforms_ahead_s =
      std::max(contents->transforms_ahead_s, secondsBetween(scan->newest, stamp));
}

// Keeps a URDF or an SRDF. Several robots may have one topic, whose texts are kept once.
void lookAtText(const BagMessage& message, BagContents* contents) {
  for (const BagTopics::Robot& robot : contents->chosen.robots) {
    if (robot.description == message.topic) {
      addChange(message.received, toText(message), std::equal_to<>(),
                &contents->robot_descriptions[message.topic]);
    }
    if (robot.semantic == message.topic) {
      contents->robot_semantics[message.topic] = toText(message);
    }
  }
}

// Link meshes that cannot be read hide the links, as others that are rejected do. Throws then, so
// that they are counted as damaged, too.
void lookAtLinks(const BagMessage& message, BagContents* contents) {
  const auto same = [](const RecordedLinkMeshes& a, const RecordedLinkMeshes& b) {
    return a.message.meshes == b.message.meshes && a.problem == b.problem;
  };
  RecordedLinkMeshes links;
  try {
    links.message = toLinkMeshes(message);
  } catch (const std::exception& error) {
    links.problem = error.what();
  }
  addChange(message.received, links, same, &contents->link_meshes);
  if (!links.problem.empty()) throw std::runtime_error(links.problem);
}

void lookAt(const BagMessage& message, Scan* scan, BagContents::Topic* topic,
            BagContents* contents) {
  const BagTopics& chosen = contents->chosen;
  const auto is_on = [&message](const std::string& name) { return message.topic == name; };
  if (isTransforms(message) && chosen.transforms.count(message.topic) > 0) {
    lookAtTransforms(message, scan, contents);
  }
  if (isJointState(message) && is_on(chosen.joint_states)) {
    lookAtJoints(message, scan, contents);
  }
  if (isMesh(message)) lookAtMesh(message, scan, topic, contents);
  if (isLinkMeshes(message) && is_on(chosen.link_meshes)) lookAtLinks(message, contents);
  if (isText(message)) lookAtText(message, contents);
}

// Sorts the meshes in the order of their cycles. A mesh whose stamp is so far behind that no
// transform of it can be kept has its cycle in the order of receipt, so that nothing waits for it.
void sortMeshes(BagContents* contents) {
  constexpr double kFarBehindS = 600;
  struct Topic {
    std::size_t part = 0;
    ros::Time newest;
  };
  std::map<std::string, Topic> topics;
  for (BagContents::Mesh& mesh : contents->meshes) {
    Topic& topic = topics[mesh.topic];
    mesh.part = contents->jumps.partOf(topicSource(mesh.topic), mesh.received);
    if (mesh.part != topic.part) topic = {mesh.part, ros::Time()};
    const bool is_far = secondsBetween(topic.newest, mesh.stamp) > kFarBehindS;
    mesh.place = is_far ? topic.newest : mesh.stamp;
    // A stamp from far ahead says nothing about those after it.
    if (topic.newest.isZero() || secondsBetween(mesh.place, topic.newest) <= kFarBehindS) {
      topic.newest = std::max(topic.newest, mesh.place);
    }
  }
  std::sort(contents->meshes.begin(), contents->meshes.end(),
            [](const BagContents::Mesh& a, const BagContents::Mesh& b) {
              return std::tie(a.part, a.place, a.number) < std::tie(b.part, b.place, b.number);
            });
}

}  // namespace

bool BagContents::isUsable(const ros::Time& stamp, const ros::Time& received) const {
  return 2 * transforms_far_ahead > moving_transforms || isUsableStamp(stamp, received);
}

// Sums the damaged messages of all topics.
std::uint64_t BagContents::damaged() const {
  std::uint64_t sum = 0;
  for (const auto& [name, topic] : topics) sum += topic.damaged;
  return sum;
}

// A frame is known as a child of some transform, or as the root of the tree.
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

// Takes the latest first stamp among the frames that start within kEdgeS of the first frame. A span
// without a time belongs to a frame that has only odd stamps.
ros::Time BagContents::settled() const {
  ros::Time start, latest;
  for (const auto& [frame, span] : moving) {
    if (span.first.isZero()) continue;
    if (start.isZero() || span.first < start) start = span.first;
  }
  for (const auto& [frame, span] : moving) {
    if (secondsBetween(span.first, start) <= kEdgeS) latest = std::max(latest, span.first);
  }
  return latest;
}

// Takes the earliest last stamp among the frames that end within kEdgeS of the last frame.
ros::Time BagContents::ended() const {
  ros::Time end;
  for (const auto& [frame, span] : moving) end = std::max(end, span.last);
  ros::Time earliest = end;
  for (const auto& [frame, span] : moving) {
    if (secondsBetween(end, span.last) <= kEdgeS) earliest = std::min(earliest, span.last);
  }
  return earliest;
}

bool BagContents::isAtEdge(const ros::Time& stamp) const {
  constexpr double kLongestS = 1;  // of an edge
  if (moving.empty() || meshes.empty() || !jumps.all().empty()) return false;
  if (stamp < settled() && secondsBetween(stamp, meshes.front().stamp) <= kLongestS) {
    return true;
  }
  ros::Time end;
  for (const auto& [frame, span] : moving) end = std::max(end, span.last);
  return end < stamp && secondsBetween(stamp, end) <= kLongestS;
}

// Fixed joints become static transforms. Frames of moving joints count as known while their joint
// was recorded.
void BagContents::addJointTransforms(const History<std::string>& urdfs,
                                     const std::string& frame_prefix) {
  if (joints.empty()) return;
  const std::map<std::string, std::string> in_tf = parents;
  const auto is_missing = [&in_tf](const std::string& frame) { return in_tf.count(frame) == 0; };
  for (const Recorded<std::string>& urdf : urdfs) {
    const auto made = std::make_shared<const JointTransforms>(urdf.value, frame_prefix, is_missing);
    for (const geometry_msgs::TransformStamped& transform : made->fixed()) {
      addStatic(urdf.received, transform, "", this);
      parents[transform.child_frame_id] = transform.header.frame_id;
    }
    for (const JointTransforms::Moving& of : made->moving()) {
      const auto source = std::find_if(of.sources.begin(), of.sources.end(),
                                       [this](const auto& s) { return joints.count(s.joint) > 0; });
      if (source == of.sources.end()) continue;
      moving[of.frame] = joints.at(source->joint);
      parents[of.frame] = of.parent;
    }
    joint_transforms.push_back({urdf.received, made});
  }
  // Without any frame to compute, the cycles need no joint states.
  if (parents == in_tf) joint_transforms.clear();
}

std::string stampText(const ros::Time& stamp) {
  return formatted("%u.%09u", stamp.sec, stamp.nsec);
}

// A message that cannot be read is counted as damaged, and the reading goes on. Topics are chosen
// before the first message is used, and also if there is none.
BagContents scanBags(BagReader* reader, const BagFiles& files, const MonitorParameters& configured,
                     const std::function<void(std::uint64_t)>& progress) {
  BagContents contents;
  const auto choose = [&] {
    contents.recorded = reader->topics();
    contents.chosen = chooseTopics(contents.recorded, files, configured);
  };
  Scan scan;
  for (const ObjectParameters& object : configured.objects) scan.objects[topicOf(object)] = object;
  std::uint64_t count = 0;
  contents.problem = reader->read([&](const BagMessage& message) {
    if (count == 0) choose();
    if (files.bags.size() > 1 && isMesh(message)) {
      BagMessage& last = scan.last_meshes[message.topic];
      contents.repeated_meshes += last.received == message.received && last.bytes == message.bytes;
      last = message;
    }
    progress(++count);
    BagContents::Topic& topic = contents.topics[message.topic];
    topic.type = message.type;
    ++topic.messages;
    try {
      lookAt(message, &scan, &topic, &contents);
    } catch (const std::exception& error) {
      if (topic.damaged++ == 0) topic.damage = error.what();
    }
  });
  if (count == 0) choose();
  contents.jumps.finish();
  sortMeshes(&contents);
  std::vector<TrianglesAhead::Cycle> cycles;
  for (const BagContents::Mesh& mesh : contents.meshes) cycles.push_back({mesh.number, mesh.part});
  contents.triangles_ahead.settle(cycles);
  return contents;
}

}  // namespace deformable_contact_monitor
