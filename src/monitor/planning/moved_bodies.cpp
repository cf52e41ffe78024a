// Which bodies the states of a question move, and where they are in each state.
#include "monitor/planning/moved_bodies.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "monitor/cycle/rigid_place.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kMostFrames = 1000;  // above a frame: TF has no loops, unless it changes meanwhile

// Returns the frame that is above this one in TF at present; empty: there is none.
std::string frameAbove(const std::string& frame, const tf2::BufferCore& transforms) {
  std::string parent;
  return transforms._getParent(frame, ros::Time(0), parent) ? parent : "";
}

// Returns the frame at the top of the tree that this one is in.
std::string rootFrame(std::string frame, const tf2::BufferCore& transforms) {
  for (int i = 0; i < kMostFrames; ++i) {
    std::string above = frameAbove(frame, transforms);
    if (above.empty()) break;
    frame = std::move(above);
  }
  return frame;
}

// Joins robots that stand on one another. Where TF has a robot's root below a link of another
// robot, a floating joint between the two is added: what TF says of it at present holds in each
// state.
class JoinedRobots {
 public:
  JoinedRobots(std::vector<RobotJoint> joints, const MonitorParameters& parameters)
      : joints_(std::move(joints)) {
    for (const RobotJoint& joint : joints_) {
      parents_.emplace(joint.child, joint.parent);
      links_.emplace(parameters.frameOf(joint.child), joint.child);
    }
    for (const RobotJoint& joint : joints_) {
      if (parents_.count(joint.parent) > 0) continue;
      links_.emplace(parameters.frameOf(joint.parent), joint.parent);
      roots_.emplace(joint.parent, parameters.frameOf(joint.parent));
    }
  }

  std::vector<RobotJoint> join(const tf2::BufferCore& transforms) && {
    if (roots_.size() < 2) return std::move(joints_);
    for (const auto& [root, frame] : roots_) {
      std::string above = frame;
      for (int i = 0; i < kMostFrames; ++i) {
        above = frameAbove(above, transforms);
        const auto link = links_.find(above);
        if (above.empty() || (link != links_.end() && joinTo(link->second, root))) break;
      }
    }
    return std::move(joints_);
  }

 private:
  // Returns false for a link of the same robot, or of one that stands on it.
  bool joinTo(const std::string& link, const std::string& root) {
    std::string lowest = link;
    for (std::size_t i = 0; i < parents_.size() && lowest != root; ++i) {
      const auto parent = parents_.find(lowest);
      if (parent == parents_.end()) break;
      lowest = parent->second;
    }
    if (lowest == root || parents_.count(lowest) > 0) return false;
    RobotJoint joint;
    joint.name = "'" + root + "' on '" + link + "'";
    joint.parent = link;
    joint.child = root;
    joint.type = RobotJoint::Type::kFloating;
    joints_.push_back(std::move(joint));
    parents_.emplace(root, link);
    return true;
  }

  std::vector<RobotJoint> joints_;
  std::map<std::string, std::string> parents_;  // links, by the links that they carry
  std::map<std::string, std::string> links_;    // by frame
  std::map<std::string, std::string> roots_;    // frames, by link
};

}  // namespace

MovedBodies::MovedBodies(const std::vector<RobotJoint>& joints,
                         const std::vector<std::string>& names, const MonitorScene& scene,
                         const MonitorParameters& parameters, const tf2::BufferCore& transforms)
    : parameters_(parameters),
      transforms_(transforms),
      motion_(JoinedRobots(joints, parameters).join(transforms), names),
      bodies_(scene.firstObject()),
      links_(motion_.movedLinks().size()) {
  const std::string root = rootFrame(parameters.reference_frame, transforms);
  for (BodyId id = 0; id < bodies_.size(); ++id) {
    findCarrier(scene.placeOf(id), joints, root, &bodies_[id]);
  }
}

// Walks from the body's frame up to `root`, that of the reference frame, until it meets a link that
// moves. A link's own frame is met at once. Where TF ends before, the URDF leads on.
void MovedBodies::findCarrier(const FramePlace& place, const std::vector<RobotJoint>& joints,
                              const std::string& root, MovedBody* body) const {
  const std::vector<std::string>& links = motion_.movedLinks();
  std::string frame = place.frame;
  for (int i = 0; i < kMostFrames; ++i) {
    const auto found = std::find_if(links.begin(), links.end(), [&](const std::string& link) {
      return parameters_.frameOf(link) == frame;
    });
    if (found != links.end()) {
      body->is_moved = true;
      body->link = static_cast<std::size_t>(found - links.begin());
      body->in_link = body->in_frame = place.frame_from_body;
      if (frame != place.frame) body->frame = place.frame;
      return;
    }
    if (frame == root) return;
    std::string above = frameAbove(frame, transforms_);
    const auto joint = std::find_if(joints.begin(), joints.end(), [&](const RobotJoint& one) {
      return above.empty() && parameters_.frameOf(one.child) == frame;
    });
    if (joint != joints.end()) above = parameters_.frameOf(joint->parent);
    if (above.empty()) break;
    frame = std::move(above);
  }
  body->is_unclear = true;
}

std::vector<std::string> MovedBodies::presentFrames(const std::set<BodyId>& bodies) const {
  std::set<std::string> frames;
  for (const std::string& link : motion_.presentLinks()) frames.insert(parameters_.frameOf(link));
  for (const BodyId id : bodies) {
    if (id >= bodies_.size() || bodies_[id].frame.empty()) continue;
    const MovedBody& body = bodies_[id];
    frames.insert({body.frame, parameters_.frameOf(motion_.movedLinks()[body.link])});
  }
  frames.erase(parameters_.reference_frame);
  return {frames.begin(), frames.end()};
}

// Looks up all bodies, also those that no question is about: it costs little, and nobody mistakes
// a place that was not looked up for one that is known.
std::string MovedBodies::lookUp(const ros::Time& t, const TransformLookup& lookup) {
  const auto at = [&](const std::string& frame, std::string* problem) {
    if (frame == parameters_.reference_frame) return RigidTransform();
    const PoseAnswer answer = lookup.lookup({{frame, t}}).front();
    if (problem->empty()) *problem = answer.problem;
    return answer.pose;
  };
  std::string of_all;
  std::vector<RigidTransform> present;
  for (const std::string& link : motion_.presentLinks()) {
    present.push_back(at(parameters_.frameOf(link), &of_all));
  }
  motion_.setPresent(present);
  for (MovedBody& body : bodies_) {
    if (body.frame.empty()) continue;
    body.problem.clear();
    const RigidTransform in_reference = at(body.frame, &body.problem);
    const std::string link = parameters_.frameOf(motion_.movedLinks()[body.link]);
    body.in_link = compose(compose(inverse(at(link, &body.problem)), in_reference), body.in_frame);
  }
  return of_all;
}

void MovedBodies::pose(const double* positions, const std::vector<BodyId>& bodies,
                       RigidTransform* poses) {
  motion_.pose(positions, links_.data());
  for (const BodyId id : bodies) {
    const MovedBody& body = bodies_[id];
    *poses++ = compose(links_[body.link], body.in_link);
  }
}

}  // namespace deformable_contact_monitor
