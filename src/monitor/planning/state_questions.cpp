// Answers what planners ask. check() is the place to start reading.
#include "monitor/planning/state_questions.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "monitor/input/usable_stamp.h"
#include "monitor/planning/answer_writer.h"
#include "monitor/state/rejected_sides.h"
#include "monitor/time_difference.h"
#include "robot/nearest_name.h"

namespace deformable_contact_monitor {
namespace {

[[noreturn]] void refuseQuestion(const std::string& why) { throw std::invalid_argument(why); }

// Refuses a question whose numbers cannot be used.
void requireNumbers(const StatesToCheck& question) {
  const std::size_t joints = question.joint_names.size(), numbers = question.positions.size();
  if (joints == 0) refuseQuestion("joint_names is empty");
  if (numbers == 0) refuseQuestion("positions is empty");
  if (numbers % joints != 0) {
    refuseQuestion("positions has " + std::to_string(numbers) +
                   " numbers, which is no multiple of the " + std::to_string(joints) +
                   " joint_names");
  }
  for (std::size_t i = 0; i < numbers; ++i) {
    if (std::isfinite(question.positions[i])) continue;
    refuseQuestion("positions[" + std::to_string(i) + "], of joint '" +
                   question.joint_names[i % joints] + "' in state " + std::to_string(i / joints) +
                   ", is not finite");
  }
  if (!std::isfinite(question.margin) || question.margin > kMaxMarginM) {
    refuseQuestion("margin is " + std::to_string(question.margin) +
                   " m; it must be a number of at most 10");
  }
  if (question.max_time < ros::Duration()) refuseQuestion("max_time is negative");
}

// Returns why something of that age says nothing about the present; empty: it does. What is stamped
// ahead of the clock is from before a jump of the clock.
std::string presentProblem(const std::string& what, double age_s, double max_age_s) {
  const bool is_ahead = age_s < -kMaxAheadS;
  if (age_s <= max_age_s && !is_ahead) return "";
  char text[64];
  std::snprintf(text, sizeof text, " %.3f s %s", std::abs(age_s),
                is_ahead ? "ahead of the clock" : "old");
  return what + text;
}

// Returns which of the limits is reached; empty: none.
std::string reachedLimit(const Limits& limits) {
  if (limits.stop != nullptr && *limits.stop) return "stopped";
  if (limits.deadline == SteadyTime::max()) return "";
  return std::chrono::steady_clock::now() >= limits.deadline ? kNoTime : "";
}

// Gives all bodies one margin, and their own again when it goes out of scope. A negative margin
// leaves them as they are.
class MarginOfQuestion {
 public:
  MarginOfQuestion(float margin_m, Scene* scene) : scene_(scene) {
    if (margin_m < 0) return;
    for (const Body& body : scene->bodies())
      own_.emplace_back(body.own_margin_m, body.part_margins_m);
    for (BodyId id = 0; id < own_.size(); ++id) {
      if (!own_[id].second.empty()) scene_->setPartMargins(id, {});
      scene_->setMargin(id, margin_m);
    }
  }
  MarginOfQuestion(const MarginOfQuestion&) = delete;
  MarginOfQuestion& operator=(const MarginOfQuestion&) = delete;
  ~MarginOfQuestion() {
    for (BodyId id = 0; id < own_.size(); ++id) {
      scene_->setMargin(id, own_[id].first);
      if (!own_[id].second.empty()) scene_->setPartMargins(id, own_[id].second);
    }
  }

 private:
  Scene* const scene_;
  std::vector<std::pair<float, std::map<PartId, float>>> own_;
};

// Leaves out the pairs of moved bodies whose place is not known, until it goes out of scope.
class UnplacedBodies {
 public:
  UnplacedBodies(const std::vector<MonitoredPair>& pairs, const MovedBodies& moved, Scene* scene)
      : scene_(scene) {
    for (const MonitoredPair& pair : pairs) {
      if (!scene->pairEnabled(pair.a, pair.b)) continue;
      if (moved.problemOf(pair.a).empty() && moved.problemOf(pair.b).empty()) continue;
      scene->setPairEnabled(pair.a, pair.b, false);
      left_out_.push_back(pair);
    }
  }
  UnplacedBodies(const UnplacedBodies&) = delete;
  UnplacedBodies& operator=(const UnplacedBodies&) = delete;
  ~UnplacedBodies() {
    for (const MonitoredPair& pair : left_out_) scene_->setPairEnabled(pair.a, pair.b, true);
  }

 private:
  Scene* const scene_;
  std::vector<MonitoredPair> left_out_;
};

}  // namespace

StateQuestions::StateQuestions(const MonitorParameters& parameters, QuestionSources sources,
                               std::unique_ptr<StateChecker> checker, int threads)
    : parameters_(parameters),
      sources_(std::move(sources)),
      threads_(threads),
      checker_(std::move(checker)),
      scene_(parameters),
      lookup_(sources_.transforms, parameters.reference_frame) {}

StatesChecked StateQuestions::answer(const StatesToCheck& question) {
  const SteadyTime start = std::chrono::steady_clock::now();
  StatesChecked answer;
  try {
    const std::lock_guard<std::mutex> lock(mutex_);
    check(question, start, &answer);
    answer.success = true;
  } catch (const std::exception& error) {
    answer = StatesChecked();
    answer.reason = error.what();
  }
  answer.id = question.id;
  answer.compute_time = toDuration(secondsSince(start));
  return answer;
}

// Takes over the robot and the rules in force, if they have changed.
void StateQuestions::followRules() {
  const InForce in_force = sources_.requests.inForce();
  if (!in_force.enabled) refuseQuestion("the monitor is disabled (~set_enabled)");
  if (!parameters_.pair_classes.needRobot())
    refuseQuestion("no robot is monitored (~pair_classes)");
  const std::shared_ptr<const RobotGeometry> robot = sources_.newest_robot();
  if (robot == nullptr) refuseQuestion("no robot received yet");
  if (robot->joints.empty()) {
    refuseQuestion(
        "the robot's joints are not known, because it has no URDF (~robot_source: topic)");
  }
  if (robot != robot_) {
    scene_.setRobot(*robot);
    checker_->reset();
    robot_ = robot;
    revision_.reset();
  }
  if (revision_ == in_force.revision) return;
  if (in_force.live) {
    scene_.setMargin(in_force.live->margin_m);
    scene_.setPairClasses(in_force.live->pair_classes);
  }
  scene_.setAllowedContacts(*in_force.allowed_contacts);
  scene_.setAttached(*in_force.attached);
  revision_ = in_force.revision;
}

void StateQuestions::check(const StatesToCheck& question, SteadyTime start, StatesChecked* answer) {
  requireNumbers(question);
  followRules();
  const ros::Time now = sources_.now();
  if (now.isZero()) refuseQuestion("no clock: use_sim_time is set, and nothing came on /clock");
  Limits limits{SteadyTime::max(), &sources_.requests.stopped()};
  if (!question.max_time.isZero()) limits.deadline = start + fromSeconds(question.max_time.toSec());

  MovedBodies moved(robot_->joints, question.joint_names, scene_, parameters_, sources_.transforms);
  const StatesAsked asked = pairsOf(question, moved);
  const ObjectMeshes meshes = newestMeshes(asked, now, limits.deadline);
  answer->stamp = presentStamp(moved, asked, now);
  std::string unknown = moved.lookUp(answer->stamp, lookup_);
  if (unknown.empty()) {
    unknown = presentProblem("the newest transforms are", secondsBetween(now, answer->stamp),
                             parameters_.max_mesh_age_s);
  }
  const auto choose = [&](std::size_t object, std::string* why_not) -> const IncomingMesh* {
    *why_not = meshes[object].problem;
    return why_not->empty() ? &*meshes[object].mesh : nullptr;
  };
  scene_.prepareStates(answer->stamp, asked, choose, lookup_);
  nameObjects(question, asked, meshes, answer);
  const std::size_t joints = question.joint_names.size();
  for (std::size_t i = 0; i < question.positions.size(); i += joints) {
    answer->beyond_limits.push_back(moved.isBeyondLimits(&question.positions[i]));
  }
  if (unknown.empty()) {
    checkStates(question, asked, limits, &moved, answer);
  } else {
    AnswerWriter(scene_, asked, !question.first_only, unknown, answer)
        .add(resultsWithoutCheck(answer->beyond_limits.size(), PairDecision::kOpen));
  }
}

// Refuses objects that do not exist, and those that nothing would be checked with: "free" would be
// misleading.
StatesAsked StateQuestions::pairsOf(const StatesToCheck& question, const MovedBodies& moved) const {
  const std::vector<BodyStatus>& bodies = scene_.bodies();
  StatesAsked asked;
  std::vector<std::string> objects;
  for (BodyId id = 0; id < bodies.size(); ++id) {
    asked.moved.push_back(moved.isMoved(id));
    asked.unclear.push_back(moved.isUnclear(id));
    asked.asked.push_back(question.objects.empty());
    if (id >= scene_.firstRigid()) objects.push_back(bodies[id].name);
  }
  const auto has_pair = [&](const StatesAsked& of) {
    return std::any_of(scene_.pairs().begin(), scene_.pairs().end(),
                       [&](const MonitoredPair& pair) { return pair.a != pair.b && of.has(pair); });
  };
  for (const std::string& name : question.objects) {
    const auto found = std::find(objects.begin(), objects.end(), name);
    if (found == objects.end()) {
      refuseQuestion("there is no object '" + name + "'" + nearestNameHint(name, objects));
    }
    const auto id = scene_.firstRigid() + static_cast<BodyId>(found - objects.begin());
    if (asked.asked[id]) continue;
    StatesAsked of_one = asked;
    of_one.asked.assign(bodies.size(), false);
    of_one.asked[id] = asked.asked[id] = true;
    if (!has_pair(of_one)) {
      refuseQuestion(
          "object '" + name +
          "' has no monitored pair with anything that these joints move (~pair_classes, ~links)");
    }
  }
  if (!has_pair(asked)) {
    refuseQuestion("no monitored pair has anything that these joints move (~pair_classes, ~links)");
  }
  return asked;
}

// Returns the bodies of the pairs that the states decide about.
std::set<BodyId> StateQuestions::bodiesOf(const StatesAsked& asked) const {
  std::set<BodyId> bodies;
  for (const MonitoredPair& pair : scene_.pairs()) {
    if (!pair.allowed && asked.has(pair)) bodies.insert({pair.a, pair.b});
  }
  return bodies;
}

// Waits for transforms of the meshes, which arrive in another thread, as a cycle does.
StateQuestions::ObjectMeshes StateQuestions::newestMeshes(const StatesAsked& asked,
                                                          const ros::Time& now,
                                                          SteadyTime deadline) {
  const bool discards = sources_.requests.inForce().discards;
  ObjectMeshes meshes(sources_.meshes.size());
  std::vector<FrameAtStamp> frames;
  const std::set<BodyId> needed = bodiesOf(asked);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    ObjectMesh& one = meshes[i];
    one.mesh = sources_.meshes[i].newest(&one.problem);
    if (!one.mesh) continue;
    const std::string& frame = one.mesh->message->header.frame_id;
    one.problem = discards
                      ? "all meshes are about to be forgotten"
                      : presentProblem("newest mesh is", secondsBetween(now, one.mesh->stamp()),
                                       parameters_.max_mesh_age_s);
    if (!one.problem.empty()) continue;
    if (needed.count(scene_.firstObject() + static_cast<BodyId>(i)) > 0 &&
        plainFrame(frame) != parameters_.reference_frame) {
      frames.push_back({plainFrame(frame), one.mesh->stamp()});
    }
  }
  const SteadyTime end =
      std::min(deadline, std::chrono::steady_clock::now() + fromSeconds(parameters_.tf_timeout_s));
  while (lookup_.isWorthWaiting(frames)) {
    if (std::chrono::steady_clock::now() >= end) {
      lookup_.giveUp(frames);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return meshes;
}

// Returns the newest stamp at which TF has all that the states do not move, but for frames that
// are too old: their bodies are UNKNOWN. Static transforms hold at any time, so they count as of
// now.
ros::Time StateQuestions::presentStamp(const MovedBodies& moved, const StatesAsked& asked,
                                       const ros::Time& now) const {
  const std::set<BodyId> bodies = bodiesOf(asked);
  std::vector<std::string> frames = moved.presentFrames(bodies);
  for (const BodyId id : bodies) {
    if (id >= scene_.firstObject() || asked.moved[id]) continue;
    const std::string frame = scene_.placeOf(id).frame;
    if (frame != parameters_.reference_frame) frames.push_back(frame);
  }
  const double window_s = parameters_.max_mesh_age_s;
  const auto newest = [&](const std::vector<std::string>& of) {
    return lookup_.newestCommon(of, window_s, now).value_or(ros::Time());
  };
  const auto is_old = [&](const std::string& frame) {
    const ros::Time stamp = newest({frame});
    return !stamp.isZero() && secondsBetween(now, stamp) > window_s;
  };
  frames.erase(std::remove_if(frames.begin(), frames.end(), is_old), frames.end());
  const ros::Time stamp = newest(frames);
  return stamp.isZero() ? now : stamp;
}

void StateQuestions::nameObjects(const StatesToCheck& question, const StatesAsked& asked,
                                 const ObjectMeshes& meshes, StatesChecked* answer) const {
  const std::set<BodyId> looked_at = bodiesOf(asked);
  for (BodyId id = scene_.firstRigid(); id < scene_.bodies().size(); ++id) {
    if (question.objects.empty() ? looked_at.count(id) == 0 : !asked.asked[id]) continue;
    const BodyStatus& body = scene_.bodies()[id];
    answer->objects.push_back(body.name);
    const bool has_messages = id >= scene_.firstObject();
    const std::optional<IncomingMesh> none;
    const auto& mesh = has_messages ? meshes[id - scene_.firstObject()].mesh : none;
    answer->object_stamps.push_back(mesh ? mesh->stamp() : body.stamp);
  }
}

// Returns which bodies of the pairs are not known, and why, the first few of them.
std::string StateQuestions::whyUnknown(const StatesAsked& asked, const MovedBodies& moved) const {
  constexpr std::size_t kShown = 5;
  const auto problem = [&](BodyId id) {
    const std::string& because = scene_.bodies()[id].unknown_because;
    return because.empty() ? moved.problemOf(id) : because;
  };
  std::vector<BodyId> unknown;
  for (const BodyId id : bodiesOf(asked)) {
    if (asked.unclear[id] || !problem(id).empty()) unknown.push_back(id);
  }
  std::string text;
  std::size_t shown = 0;
  for (const BodyId id : unknown) {
    if (shown++ == kShown)
      return text + "; and " + std::to_string(unknown.size() - kShown) + " more";
    const std::string because = problem(id);
    text += (text.empty() ? "" : "; ") + scene_.bodies()[id].name + ": ";
    if (asked.unclear[id]) text += "it is not known whether it moves with the joints";
    if (asked.unclear[id] && !because.empty()) text += ": ";  // else TF came meanwhile
    text += because;
  }
  return text;
}

// Returns why rejected triangles, or parts that nobody knows, leave it open how a pair stands.
std::string StateQuestions::rejectsProblem(const std::vector<RejectedPart>& rejected,
                                           const StatesAsked& asked) const {
  CycleReport report = scene_.makeReport(ros::Time(), 0);
  report.scene = &scene_.scene();
  for (const RejectedPart& part : rejected) {
    BodyStatus& body = report.bodies[part.body];
    body.rejected += part.count;
    if (scene_.scene().body(part.body).parts.empty()) continue;
    body.rejected_by_part.resize(body.pieceCount());
    body.rejected_by_part.at(part.part) += part.count;
  }
  for (std::size_t i = 0; i < statePairCount(report); ++i) {
    const MonitoredPair& pair = statePair(report, i);
    if (pair.allowed || !asked.has(pair) || !scene_.scene().pairEnabled(pair.a, pair.b)) continue;
    for (const bool is_a : {true, false}) {
      const BodyStatus& body = report.bodies[is_a ? pair.a : pair.b];
      std::string problem = deformable_contact_monitor::rejectsProblem(
          report, pair, is_a, {body.rejected, body.rejected_by_part},
          parameters_.tolerated_rejects);
      if (!problem.empty()) return problem;
    }
  }
  return "";
}

// Returns the moved bodies of the enabled pairs.
std::vector<BodyId> StateQuestions::posedBodies(const StatesAsked& asked) const {
  std::vector<BodyId> posed;
  for (BodyId id = 0; id < scene_.bodies().size(); ++id) {
    if (asked.moved[id] && scene_.scene().takesPart(id)) posed.push_back(id);
  }
  return posed;
}

// Poses the states of a batch, from `first` on. Returns which limit ended that; empty: none.
std::string StateQuestions::poseStates(const StatesToCheck& question, std::size_t first,
                                       const StateBatch& batch, const Limits& limits,
                                       MovedBodies* moved, RigidTransform* poses) {
  constexpr std::size_t kStatesBetweenLooks = 256;
  const std::size_t joints = question.joint_names.size();
  for (std::size_t i = 0; i < batch.count; ++i) {
    if (i % kStatesBetweenLooks == 0) {
      std::string reached = reachedLimit(limits);
      if (!reached.empty()) return reached;
    }
    moved->pose(&question.positions[(first + i) * joints], batch.moved,
                poses + i * batch.moved.size());
  }
  return "";
}

// Poses and checks some thousand states at a time, which bounds the memory of the poses.
void StateQuestions::checkStates(const StatesToCheck& question, const StatesAsked& asked,
                                 const Limits& limits, MovedBodies* moved, StatesChecked* answer) {
  constexpr std::size_t kStatesAtOnce = 8192;
  const MarginOfQuestion margin(question.margin, &scene_.sceneOfStep());
  const UnplacedBodies unplaced(scene_.pairs(), *moved, &scene_.sceneOfStep());
  StateBatch batch;
  batch.moved = posedBodies(asked);
  StateOptions options;
  options.nearest = question.margin != 0;
  options.pairs = !question.first_only && !options.nearest;
  options.threads = threads_;
  options.limits = limits;
  std::optional<AnswerWriter> results;
  std::vector<RigidTransform> poses;
  const std::size_t states = answer->beyond_limits.size();
  std::string cut_off_because;
  for (std::size_t first = 0; first < states; first += kStatesAtOnce) {
    batch.count = std::min(kStatesAtOnce, states - first);
    poses.resize(batch.count * batch.moved.size());
    batch.poses = poses.data();
    if (cut_off_because.empty() && !batch.moved.empty()) {
      cut_off_because = poseStates(question, first, batch, limits, moved, poses.data());
    }
    StateResults without_check;
    if (batch.moved.empty()) {
      without_check = resultsWithoutCheck(batch.count, PairDecision::kNone);
    } else if (!cut_off_because.empty()) {
      without_check = resultsWithoutCheck(batch.count, PairDecision::kOpen);
      without_check.cut_off = true;
      without_check.cut_off_because = cut_off_because;
    }
    const bool is_checked = without_check.states.empty();
    const StateResults& found =
        is_checked ? checker_->check(scene_.scene(), batch, options) : without_check;
    if (found.cut_off) cut_off_because = found.cut_off_because;
    if (!results) {
      std::string unknown = whyUnknown(asked, *moved);
      if (unknown.empty()) unknown = rejectsProblem(found.rejected, asked);
      results.emplace(scene_, asked, !question.first_only, std::move(unknown), answer);
    }
    results->add(found);
  }
}

}  // namespace deformable_contact_monitor
