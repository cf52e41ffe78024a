// Which bodies the states of a question move, and where they are in each state.
#include "monitor/planning/moved_bodies.h"

#include <algorithm>
#include <set>

#include "monitor/cycle/rigid_place.h"

namespace deformable_contact_monitor {

MovedBodies::MovedBodies(const std::vector<RobotJoint>& joints,
                         const std::vector<std::string>& names, const MonitorScene& scene,
                         const MonitorParameters& parameters, const tf2::BufferCore& transforms)
    : parameters_(parameters),
      transforms_(transforms),
      motion_(joints, names),
      bodies_(scene.firstObject()),
      links_(motion_.movedLinks().size()) {
  for (BodyId id = 0; id < bodies_.size(); ++id) findCarrier(scene.placeOf(id), &bodies_[id]);
}

// Walks from the body's frame up to the root of TF until it meets a link that moves. A link's own
// frame is met at once. Of a link whose joint is missing in the URDF nothing is known.
void MovedBodies::findCarrier(const FramePlace& place, MovedBody* body) const {
  constexpr int kMostFrames = 1000;  // TF has no loops, unless it changes meanwhile
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
    std::string parent;
    if (!transforms_._getParent(frame, ros::Time(0), parent) || parent.empty()) return;
    frame = std::move(parent);
  }
}

std::vector<std::string> MovedBodies::presentFrames() const {
  std::set<std::string> frames;
  for (const std::string& link : motion_.presentLinks()) frames.insert(parameters_.frameOf(link));
  for (const MovedBody& body : bodies_) {
    if (body.frame.empty()) continue;
    frames.insert({body.frame, parameters_.frameOf(motion_.movedLinks()[body.link])});
  }
  frames.erase(parameters_.reference_frame);
  return {frames.begin(), frames.end()};
}

std::string MovedBodies::lookUp(const ros::Time& t, const TransformLookup& lookup) {
  std::string problem;
  const auto at = [&](const std::string& frame) {
    if (frame == parameters_.reference_frame) return RigidTransform();
    const PoseAnswer answer = lookup.lookup({{frame, t}}).front();
    if (problem.empty()) problem = answer.problem;
    return answer.pose;
  };
  std::vector<RigidTransform> present;
  for (const std::string& link : motion_.presentLinks()) {
    present.push_back(at(parameters_.frameOf(link)));
  }
  motion_.setPresent(present);
  for (MovedBody& body : bodies_) {
    if (body.frame.empty()) continue;
    const RigidTransform link = at(parameters_.frameOf(motion_.movedLinks()[body.link]));
    body.in_link = compose(compose(inverse(link), at(body.frame)), body.in_frame);
  }
  return problem;
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
