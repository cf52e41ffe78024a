// Plans a cycle for each mesh of the bags, and runs it once everything that it needs is read.
#include "tools/bags/bag_cycles.h"

#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <exception>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// A transform may be recorded this much later than the mesh of its stamp [s].
constexpr double kLookAheadS = 2;
constexpr double kUsualCacheS = 10;     // tf2's default
constexpr double kLongestCacheS = 600;  // limits the memory if a stamp is wrong

// Adds seconds, which may be negative. ros::Time would throw below zero.
ros::Time plus(const ros::Time& time, double seconds) {
  const std::int64_t ns = static_cast<std::int64_t>(time.toNSec()) + std::llround(1e9 * seconds);
  return ros::Time().fromNSec(static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0)));
}

// Returns how long transforms must stay known, so that the last mesh that may need them has had its
// cycle: a mesh waits for those before it in the order of stamps, and its time interval begins at
// most max_mesh_age_s earlier.
ros::Duration cacheTime(const BagContents& contents, double max_mesh_age_s) {
  double waits_s = 0;
  ros::Time read_up_to;
  for (const BagContents::Mesh& mesh : contents.meshes) {
    read_up_to = std::max(read_up_to, mesh.received);
    waits_s = std::max(waits_s, secondsBetween(read_up_to, mesh.received));
  }
  return ros::Duration(
      std::min(kUsualCacheS + kLookAheadS + contents.transforms_ahead_s + waits_s + max_mesh_age_s,
               kLongestCacheS));
}

}  // namespace

BagCycles::BagCycles(const MonitorParameters& parameters, const BagContents& contents,
                     const History<RobotGeometry>& robots, const PlayedObject* played)
    : parameters_(parameters),
      contents_(contents),
      robots_(robots),
      played_(played),
      scene_(parameters),
      inputs_(makeMeshInputs(parameters)),
      buffer_([this] { return reading_; }, parameters.maxTransformGapS(),
              cacheTime(contents, parameters.max_mesh_age_s)),
      lookup_(buffer_, parameters.reference_frame),
      planner_(parameters) {
  for (const ObjectParameters& object : parameters.objects) {
    input_of_topic_[topicOf(object)] = mesh_readers_.size();
    mesh_readers_.push_back(recordedMeshReader(object));
  }
  if (parameters.pair_classes.needRobot()) scene_.setRobot(robots.front().value);
  for (const auto& [frame, transforms] : contents.static_transforms) {
    addTransform(transforms.front().value.transform, transforms.front().value.publisher, true);
    if (transforms.size() > 1) changing_frames_.push_back({&transforms, 0});
    for (std::size_t i = 1; i < transforms.size(); ++i) changes_.insert(transforms[i].received);
  }
  for (std::size_t i = 1; i < robots.size(); ++i) changes_.insert(robots[i].received);
  refused_transforms_ += contents.refused_transforms;
  bad_transforms_ += contents.refused_transforms;
  plan(contents);
  for (std::size_t i = 0; i < events_.size(); ++i) {
    if (!events_[i].played) event_of_mesh_[events_[i].number] = i;
  }
}

// Lists the cycles in advance, in the order of stamps. A played object gets cycles at its own rate
// while all moving frames are known.
void BagCycles::plan(const BagContents& contents) {
  for (const BagContents::Mesh& mesh : contents.meshes) {
    const auto input = input_of_topic_.find(mesh.topic);
    if (input == input_of_topic_.end()) continue;
    events_.push_back({mesh.stamp, plus(mesh.received, kLookAheadS), mesh.received, false,
                       input->second, mesh.number, mesh.part, mesh.place, mesh.is_passing});
    if (mesh.part < contents.jumps.partAt(mesh.received)) leftovers_[mesh.number] = mesh.part;
  }
  if (played_ == nullptr) return;
  // Before and after, some link would be UNKNOWN in every cycle.
  const ros::Time first = contents.settled(), last = contents.ended();
  if (last.isZero()) return;
  constexpr double kMostCycles = 1e7;  // four days at 30 Hz
  if (secondsBetween(last, first) * played_->rate_hz > kMostCycles) {
    throw std::runtime_error("from the first moving transform to the last it is " +
                             std::to_string(secondsBetween(last, first)) +
                             " s, which are too many cycles: the clock leapt; evaluate the part "
                             "before or after that (rosbag filter)");
  }
  std::size_t input = 0;
  while (parameters_.objects[input].name != played_->object) ++input;
  for (std::uint64_t i = 0;; ++i) {
    const double since_s = static_cast<double>(i) / played_->rate_hz;
    const ros::Time stamp = plus(first, since_s);
    if (stamp > last) break;
    events_.push_back({stamp, plus(stamp, kLookAheadS), stamp, true, input, 0,
                       contents.jumps.all().size(), stamp, false});
  }
  std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
    return std::tie(a.part, a.place) < std::tie(b.part, b.place);
  });
}

// After the end of the bags, nothing can come any more, so the remaining cycles run at once.
std::string BagCycles::run(BagReader* reader, const std::function<void(CycleReport*)>& visit) {
  std::string problem = reader->read([&](const BagMessage& message) {
    startParts(contents_.jumps.partAt(message.received), false, visit);
    // First the cycles that wait for nothing more: after a gap in the recording, this message's
    // transforms may make the buffer drop those that they need.
    received_ = std::max(received_, message.received);
    release(visit);
    take(message);
    release(visit);
  });
  startParts(contents_.jumps.partAt(received_), true, visit);
  at_end_ = true;
  release(visit);
  return problem;
}

// Keeps a mesh until its cycle, and hands transforms to the buffer at once.
void BagCycles::take(const BagMessage& message) {
  reading_ = message.received;
  noteLate(message.received);
  for (; !changes_.empty() && *changes_.begin() <= message.received;
       changes_.erase(changes_.begin())) {
    postpone(*changes_.begin());
  }
  if (isMesh(message)) {
    const std::uint64_t number = meshes_read_++;
    if (input_of_topic_.count(message.topic) > 0) {
      held_[number] = message;
      awaiting_.push_back(number);
    }
    leftovers_.erase(number);
    return;
  }
  // While leftovers are awaited, the transforms of the next part wait too.
  if (contents_.jumps.partAt(message.received) > part_) postponed_.push_back(message);
  try {
    takeTransforms(message);
  } catch (const std::exception&) {  // scanBags() has counted it
  }
}

// Adds the transforms of a message to the buffer, except the static ones of static frames. Those
// are added by recallTransforms().
void BagCycles::takeTransforms(const BagMessage& message) {
  const BagTopics& chosen = contents_.chosen;
  if (isTransforms(message) && chosen.transforms.count(message.topic) > 0) {
    for (const geometry_msgs::TransformStamped& transform : toTransforms(message).transforms) {
      const std::string frame = plainFrame(transform.child_frame_id);
      const bool is_fixed = contents_.static_transforms.count(frame) > 0;
      // A static transform of a frame that is neither was refused in the first reading.
      if (is_fixed ? isStatic(message.topic) : contents_.moving.count(frame) == 0) continue;
      if (is_fixed) recallTransforms(message.received);  // what this one is compared with
      const ros::Time& stamp = transform.header.stamp;
      if (contents_.jumps.partOf(frameSource(frame), message.received) != part_) continue;
      if (contents_.isUsable(stamp, message.received)) {
        addTransform(transform, message.publisher, isStatic(message.topic));
      } else {
        ++refused_transforms_;
        ++bad_transforms_;
      }
    }
  } else if (isJointState(message) && message.topic == chosen.joint_states &&
             !contents_.joint_transforms.empty()) {
    const auto& all = contents_.joint_transforms;
    const JointTransforms& joints = *all[indexAt(all, message.received)].value;
    const sensor_msgs::JointState state = toJointState(message);
    const std::string source = jointSource(state.name.empty() ? "" : state.name.front());
    if (contents_.jumps.partOf(source, message.received) != part_) return;
    for (const geometry_msgs::TransformStamped& transform : joints.at(state)) {
      addTransform(transform, message.publisher, false);
    }
  }
  notePlayed(message.received);
}

void BagCycles::addTransform(const geometry_msgs::TransformStamped& transform,
                             const std::string& publisher, bool is_static) {
  const std::string source = publisher.empty() ? "the bag" : publisher;
  if (!buffer_.add(transform, source, is_static, SteadyTime())) {
    ++refused_transforms_;
    bad_transforms_ += !isValid(transform);
  }
  if (!is_static) newest_transform_ = std::max(newest_transform_, transform.header.stamp);
}

// A played mesh counts as recorded together with the first transform that is not older.
void BagCycles::notePlayed(const ros::Time& received) {
  for (; next_played_ < events_.size(); ++next_played_) {
    Event& event = events_[next_played_];
    if (event.part > part_ || event.stamp > newest_transform_) return;
    if (event.played) event.due = received;
  }
}

// Puts off the cycles that still wait for transforms when something changes.
void BagCycles::postpone(const ros::Time& change) {
  for (const auto& [number, message] : held_) {
    const auto index = event_of_mesh_.find(number);
    if (secondsBetween(change, message.received) > parameters_.tf_timeout_s) continue;
    if (index == event_of_mesh_.end() || !isLate(events_[index->second], message)) continue;
    events_[index->second].due = change;
  }
}

// Returns whether the node would wait for the transforms of this mesh.
bool BagCycles::isLate(const Event& event, const BagMessage& message) const {
  const auto posed = boost::make_shared<DeformableMesh>();
  std_msgs::Header& header = posed->header;
  try {
    header.frame_id = parameters_.objects[event.input].frame_id;
    if (header.frame_id.empty()) header = headerOf(message, parameters_.objects[event.input]);
  } catch (const std::exception&) {  // scanBags() has counted it
    return false;
  }
  header.stamp = event.stamp;
  IncomingMesh mesh{posed};
  mesh.topology = std::make_shared<const Topology>();  // its triangles do not matter here
  return lookup_.isWorthWaiting(scene_.awaitedFrames(event.input, event.stamp, mesh));
}

// Notes the meshes whose transforms have not been recorded tf_timeout_s after them.
void BagCycles::noteLate(const ros::Time& received) {
  for (; !awaiting_.empty(); awaiting_.pop_front()) {
    const auto held = held_.find(awaiting_.front());
    if (held == held_.end()) continue;
    if (secondsBetween(received, held->second.received) <= parameters_.tf_timeout_s) return;
    const auto index = event_of_mesh_.find(held->first);
    if (index == event_of_mesh_.end()) continue;
    const Event& event = events_[index->second];
    if (event.part == part_ && isLate(event, held->second)) late_.insert(held->first);
  }
}

// Starts all parts up to this one, each when no mesh of the part before it is missing any more. At
// the end of the bags, none can come.
void BagCycles::startParts(std::size_t part, bool is_end,
                           const std::function<void(CycleReport*)>& visit) {
  while (part_ < part) {
    const bool is_awaited =
        std::any_of(leftovers_.begin(), leftovers_.end(),
                    [this](const auto& leftover) { return leftover.second <= part_; });
    if (is_awaited && !is_end) return;
    startPart(part_ + 1, visit);
    for (const BagMessage& message : std::exchange(postponed_, {})) take(message);
  }
}

// Ends the part of the bags before the clock went back, and forgets what depends on time, as the
// node does.
void BagCycles::startPart(std::size_t part, const std::function<void(CycleReport*)>& visit) {
  const TimeJumps::Jump& jump = contents_.jumps.all()[part - 1];
  part_ = part;
  newest_transform_ = ros::Time();
  release(visit);
  for (MeshInput& input : inputs_) input.forget();
  buffer_.forget(SteadyTime::min());  // of what was under way then, contents_.jumps decides
  forgets_ = "time jump: the clock went back by " +
             std::to_string(secondsBetween(jump.from, jump.to)) + " s";
  planner_.forgetAll(forgets_);
}

// Returns true if nothing that was recorded within kLookAheadS after the mesh is missing.
bool BagCycles::isReady(const Event& event) const {
  if (at_end_ || event.part < part_) return true;
  if (event.part > part_) return false;
  if (event.played) return newest_transform_ >= event.ready;
  return held_.count(event.number) > 0 && received_ >= event.ready;
}

// Runs the cycles whose meshes are all ready. Meshes of different objects with one stamp share a
// cycle.
void BagCycles::release(const std::function<void(CycleReport*)>& visit) {
  while (next_ < events_.size() && isReady(events_[next_])) {
    const ros::Time stamp = events_[next_].stamp, due = events_[next_].due;
    std::size_t end = next_;
    // All meshes of this stamp must be ready before its cycle runs.
    const std::size_t part = events_[next_].part;
    std::set<std::size_t> inputs;  // an object's next mesh, with the same stamp, has its own cycle
    for (; end < events_.size() && events_[end].stamp == stamp && events_[end].part == part;
         ++end) {
      if (!isReady(events_[end])) return;
      if (!knowsSame(events_[end].due, due) || !inputs.insert(events_[end].input).second) break;
    }
    recallAt(due);
    CycleTrigger trigger;
    bool is_late = false;
    for (; next_ < end; ++next_) {
      const Event& event = events_[next_];
      is_late |=
          !event.played && late_.erase(event.number) > 0 && !isLate(event, held_.at(event.number));
      std::optional<IncomingMesh> mesh = nextMesh(event);
      if (!mesh || !mesh->message || event.is_passing) continue;
      MeshInput& input = inputs_[event.input];
      // The triangles may come from a later message of the bag.
      if (!event.played) input.storeTriangles(contents_.triangles_ahead.of(event.number));
      input.store(std::move(*mesh));
      input.endGrace();
      // The rules for stamps and triangles are the node's own.
      const Acceptance answer = input.take(ros::Time(), &*mesh);
      if (answer == Acceptance::kJumped) {
        planner_.forget(event.input, "the stamps of its meshes went back");
      }
      if (answer != Acceptance::kDropped) trigger.objects.push_back(event.input);
    }
    late_cycles_ += is_late && !trigger.objects.empty();
    if (!trigger.objects.empty()) detectAt(stamp, trigger, visit);
  }
}

// Returns whether nothing changed between two times of receipt.
bool BagCycles::knowsSame(const ros::Time& a, const ros::Time& b) const {
  return a == b ||
         (indexAt(robots_, a) == indexAt(robots_, b) &&
          std::all_of(changing_frames_.begin(), changing_frames_.end(),
                      [&](const ChangingFrame& frame) {
                        return indexAt(*frame.transforms, a) == indexAt(*frame.transforms, b);
                      }));
}

// Sets the static transforms that had been recorded by then, each in its turn, because nodes may
// contradict each other. Cycles run in the order of stamps, so an earlier value may come back.
void BagCycles::recallTransforms(const ros::Time& due) {
  for (ChangingFrame& frame : changing_frames_) {
    const std::size_t index = indexAt(*frame.transforms, due);
    if (index == frame.current) continue;
    std::size_t next = std::min(frame.current + 1, index);
    for (frame.current = index; next <= index; ++next) {
      const StaticTransform& one = (*frame.transforms)[next].value;
      addTransform(one.transform, one.publisher, true);
    }
  }
}

// Sets the robot and the static transforms that had been recorded by then.
void BagCycles::recallAt(const ros::Time& due) {
  recallTransforms(due);
  const std::size_t robot = indexAt(robots_, due);
  if (robot == robot_) return;
  robot_ = robot;
  scene_.setRobot(robots_[robot].value);
  planner_.forgetAll("the robot changed");
  forgets_ = "robot changed";
}

// Returns nothing if the message is damaged or the played object has ended.
std::optional<IncomingMesh> BagCycles::nextMesh(const Event& event) {
  if (event.played) {
    const DeformableMesh::ConstPtr mesh = nextPlayed(event.stamp);
    return mesh ? std::optional(IncomingMesh{mesh}) : std::nullopt;
  }
  const auto held = held_.find(event.number);
  if (held == held_.end()) return std::nullopt;
  const BagMessage message = std::move(held->second);
  held_.erase(held);
  try {
    return mesh_readers_[event.input](message);
  } catch (const std::exception&) {  // scanBags() has counted it
    return std::nullopt;
  }
}

// Returns the played object's next state as a message; null after the last one. A simulation asks
// for the poses of the links that push it.
DeformableMesh::ConstPtr BagCycles::nextPlayed(const ros::Time& stamp) {
  if (played_out_) return nullptr;
  const std::optional<MeshFrame> frame =
      played_->next([&](const std::string& link) -> std::optional<Eigen::Isometry3d> {
        try {
          const std::string frame = parameters_.frameOf(link);
          return tf2::transformToEigen(buffer_.lookupTransform(played_->frame, frame, stamp));
        } catch (const tf2::TransformException&) {
          return std::nullopt;
        }
      });
  if (!frame) {
    played_out_ = true;
    return nullptr;
  }
  if (!frame->problem.empty() && ++undone_steps_.count == 1) undone_steps_.first = frame->problem;
  const auto message = boost::make_shared<DeformableMesh>();
  message->header.stamp = stamp;
  message->header.frame_id = played_->frame;
  message->object = played_->object;
  message->topology_id = frame->topology_id;
  message->vertices = frame->mesh.vertices;
  message->triangles = frame->mesh.triangles;
  return message;
}

// Poses the bodies at the stamp, plans the time intervals of swept motion, and hands the cycle
// over.
void BagCycles::detectAt(const ros::Time& stamp, const CycleTrigger& trigger,
                         const std::function<void(CycleReport*)>& visit) {
  scene_.prepare(stamp, trigger, inputs_, lookup_);
  CycleReport report = scene_.makeReport(stamp, ++cycle_);
  report.scene = &scene_.scene();
  report.motion = parameters_.motion;
  report.sweeps = planner_.plan(trigger, scene_, lookup_, report);
  planner_.commit();
  report.now = stamp;
  visit(&report);
  forgets_.clear();
}

}  // namespace deformable_contact_monitor
