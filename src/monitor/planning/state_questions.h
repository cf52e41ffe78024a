// Answers what planners ask: would the robot touch anything if it stood otherwise?
#pragma once

#include <deformable_contact_monitor/StatesChecked.h>
#include <deformable_contact_monitor/StatesToCheck.h>
#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/state_checker.h"
#include "core/steady_time.h"
#include "monitor/cycle/loop_requests.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/input/mesh_input.h"
#include "monitor/input/transform_buffer.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/planning/moved_bodies.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// What questions share with the detection loop. Each is thread-safe and must outlive them.
struct QuestionSources {
  LoopRequests& requests;
  const MeshInputs& meshes;
  const TransformBuffer& transforms;
  // Returns null while there is no robot, and another object when the robot has changed.
  std::function<std::shared_ptr<const RobotGeometry>()> newest_robot;
  std::function<ros::Time()> now;  // zero: no clock
};

// Checks states against the objects' newest accepted meshes, by the rules that cycles go by. It has
// a scene and a checker of its own, so that no cycle waits for it. Any thread may ask; one question
// is answered at a time.
class StateQuestions {
 public:
  // The parameters must outlive this. `threads` is what StateOptions::threads says.
  StateQuestions(const MonitorParameters& parameters, QuestionSources sources,
                 std::unique_ptr<StateChecker> checker, int threads = 0);

  // Never throws because of the question: what cannot be answered is refused with the reason. May
  // wait up to tf_timeout_s for transforms of meshes.
  StatesChecked answer(const StatesToCheck& question);

 private:
  // The newest accepted mesh of an object, or why there is none that may be used. An old mesh tells
  // its stamp all the same.
  struct ObjectMesh {
    std::optional<IncomingMesh> mesh{};
    std::string problem{};
  };
  using ObjectMeshes = std::vector<ObjectMesh>;

  void followRules();
  void check(const StatesToCheck& question, SteadyTime start, StatesChecked* answer);
  StatesAsked pairsOf(const StatesToCheck& question, const MovedBodies& moved) const;
  std::set<BodyId> bodiesOf(const StatesAsked& asked) const;
  ObjectMeshes newestMeshes(const StatesAsked& asked, const ros::Time& now, SteadyTime deadline);
  ros::Time presentStamp(const MovedBodies& moved, const StatesAsked& asked,
                         const ros::Time& now) const;
  void nameObjects(const StatesToCheck& question, const StatesAsked& asked,
                   const ObjectMeshes& meshes, StatesChecked* answer) const;
  std::string whyUnknown(const StatesAsked& asked, const MovedBodies& moved) const;
  std::string rejectsProblem(const std::vector<RejectedPart>& rejected,
                             const StatesAsked& asked) const;
  std::vector<BodyId> posedBodies(const StatesAsked& asked) const;
  static std::string poseStates(const StatesToCheck& question, std::size_t first,
                                const StateBatch& batch, const Limits& limits, MovedBodies* moved,
                                RigidTransform* poses);
  void checkStates(const StatesToCheck& question, const StatesAsked& asked, const Limits& limits,
                   MovedBodies* moved, StatesChecked* answer);

  const MonitorParameters& parameters_;
  const QuestionSources sources_;
  const int threads_;

  std::mutex mutex_;  // guards the members below
  const std::unique_ptr<StateChecker> checker_;
  MonitorScene scene_;
  TransformLookup lookup_;
  std::shared_ptr<const RobotGeometry> robot_;  // the one in scene_
  std::optional<std::uint64_t> revision_;       // of the rules in scene_
};

}  // namespace deformable_contact_monitor
