// The detection thread's work: meshes and requests in, cycles out.
#include "monitor/cycle/detection_loop.h"

#include <ros/console.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/common/parallel.h"
#include "monitor/cycle/loop_warnings.h"
#include "monitor/state/pair_summary.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {

DetectionLoop::DetectionLoop(const MonitorParameters& parameters, LoopSources sources,
                             LoopTime time, std::unique_ptr<Detector> detector,
                             std::unique_ptr<CycleSink> sink)
    : parameters_(parameters),
      sources_(std::move(sources)),
      time_(std::move(time)),
      live_(startValues(parameters)),
      options_(parameters.detector),
      detector_(std::move(detector)),
      sink_(std::move(sink)),
      clock_(parameters.max_mesh_age_s, time_.steady()),
      budget_(parameters.budget_ms / 1e3),
      turns_(maxRatesHz(live_, parameters.objects.size())),
      inputs_(makeMeshInputs(parameters)),
      scene_(parameters, detector_->vertexMemory()),
      lookup_(sources_.transforms, parameters.reference_frame),
      queues_(turns_, sources_.meshes, inputs_, scene_, lookup_),
      planner_(parameters),
      steps_(*detector_) {
  ROS_INFO_STREAM("monitoring " << inputs_.size() << " object(s) in frame '"
                                << parameters_.reference_frame << "' on the "
                                << detector_->backend());
  noteRules();
}

SteadyTime DetectionLoop::step() {
  try {
    lookAtTime();
    lookAtRequests();
    warnOfUnknownNames();
    if (time_.steady() >= list_due_) listPairs();
    dropLeftovers();
    takeMeshes();
    lookAtRobotsTime();
    const SteadyTime now = time_.steady();
    const auto turn = turns_.next([this, now](std::size_t who) {
      return who == inputs_.size() || queues_.isReady(who, now);
    });
    if (!turn.empty()) takeTurn(turn);
    if (clock_.mustBeat(time_.steady()) && !turns_.anyWaits()) heartbeat();
    return turn.empty() ? wakeTime() : time_.steady();
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("cycle failed: " << error.what());
    sink_->recordDetectorError(error.what());
    return clock_.retryTime(time_.steady());
  }
}

void DetectionLoop::lookAtTime() {
  const double back_s = clock_.update(time_.ros());
  if (back_s > 0) reset("time jump: the clock went back by " + std::to_string(back_s) + " s");
}

void DetectionLoop::lookAtRobot() {
  const std::shared_ptr<const RobotGeometry> newest = sources_.newest_robot();
  if (newest == robot_) return;
  const bool changed = robot_ != nullptr;
  scene_.setRobot(*newest);
  robot_ = newest;
  names_checked_ = false;
  noteRules();
  detector_->reset();
  planner_.forgetAll(changed ? "the robot changed" : "the robot came");
  if (changed) sink_->forgetStates("", "robot changed");
  sink_->sendRobot(*robot_);
}

void DetectionLoop::applyEnabled(bool enabled) {
  if (!enabled) {
    for (MeshMailbox& mailbox : sources_.meshes) {
      mailbox.dropIf([](const ros::Time&) { return true; });
    }
    turns_.clear();
  }
  if (enabled == enabled_) return;
  enabled_ = enabled;
  sink_->recordEnabled(enabled);
  ROS_INFO_STREAM((enabled ? "enabled" : "disabled"));
  if (!enabled) {
    planner_.forgetAll("it was disabled");
    sink_->forgetStates("", "disabled");
    heartbeat();
  }
}

void DetectionLoop::warnOfUnknownNames() {
  if (names_checked_ || (robot_ == nullptr && parameters_.pair_classes.needRobot())) return;
  names_checked_ = true;
  for (const std::string& line :
       describeUnknownNames(parameters_, scene_.rules().allowed, scene_.bodies())) {
    ROS_WARN_STREAM(line);
  }
}

void DetectionLoop::reset(const std::string& reason) {
  ROS_INFO_STREAM("reset: " << reason);
  for (MeshInput& input : inputs_) input.forget();
  turns_.clear();
  robots_stamp_ = ros::Time();
  lookup_.noteReset();
  sources_.transforms.clear();
  detector_->reset();
  planner_.forgetAll(reason);
  sink_->forgetStates("", reason);
  sink_->recordReset(reason);
  clock_.startLeftoverWindow(time_.steady());
}

void DetectionLoop::dropLeftovers() {
  const SteadyTime now = time_.steady();
  for (MeshMailbox& mailbox : sources_.meshes) {
    mailbox.dropIf([&](const ros::Time& stamp) { return clock_.isLeftover(stamp, now); });
  }
}

// One of each object, the newest. A refused one has a cycle too, in which its object is UNKNOWN.
void DetectionLoop::takeMeshes() {
  const SteadyTime now = time_.steady();
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (!turns_.mayWait(i, now)) continue;
    const std::optional<ArrivedMesh> mesh = sources_.meshes[i].take();
    if (!mesh) continue;
    const Acceptance answer = inputs_[i].accept(*mesh, clock_.rosTime());
    sink_->recordMesh(i, inputs_[i].counters());
    if (answer == Acceptance::kDropped) continue;
    if (answer == Acceptance::kJumped) {
      const std::string why = "the stamps of its meshes went back";
      planner_.forget(i, why);
      sink_->forgetStates(parameters_.objects[i].name, why);
    }
    const bool refused = answer == Acceptance::kRefused;
    queues_.add(i,
                {cycleStamp(mesh->message->header.stamp, refused), mesh->arrival,
                 now + fromSeconds(parameters_.tf_timeout_s)},
                now);
  }
}

// A refused mesh may have a senseless stamp, yet its object must become UNKNOWN at once.
ros::Time DetectionLoop::cycleStamp(const ros::Time& stamp, bool refused) const {
  const ros::Time& now = clock_.rosTime();
  if (!refused || (now.isZero() && !stamp.isZero())) return stamp;
  const double age_s = secondsBetween(now, stamp);
  return age_s >= 0 && age_s <= parameters_.max_mesh_age_s ? stamp : now;
}

// The robot's own cycles, of its links with one another.
void DetectionLoop::lookAtRobotsTime() {
  const std::size_t robot = inputs_.size();
  const SteadyTime now = time_.steady();
  if (!live_.pair_classes.robot_self || robot_ == nullptr || !enabled_) return;
  if (!turns_.waiting(robot).empty() || !turns_.mayWait(robot, now) || now < robots_look_) return;
  robots_look_ = now + fromSeconds(1 / live_.robot_rate_hz);
  const std::optional<ros::Time> stamp = robotsStamp();
  if (!stamp) return;
  robots_stamp_ = *stamp;
  turns_.wait(robot, {*stamp, now, now}, now);
}

// Of its next cycle: the newest for which transforms have the links; nothing: there was one
// already.
std::optional<ros::Time> DetectionLoop::robotsStamp() const {
  const std::vector<std::string> links = scene_.selfPairedLinks();
  if (links.empty()) return std::nullopt;
  const ros::Time now = clock_.rosTime();
  const std::optional<ros::Time> newest = lookup_.newestCommon(links, parameters_.max_mesh_age_s);
  if (!newest || newest->isZero()) return now.isZero() ? std::nullopt : std::optional(now);
  const bool is_old = !now.isZero() && secondsBetween(now, *newest) > parameters_.max_mesh_age_s;
  return *newest > robots_stamp_ && !is_old ? newest : std::nullopt;
}

void DetectionLoop::takeTurn(const std::vector<std::size_t>& who) {
  const SteadyTime now = time_.steady();
  const ros::Time stamp = turns_.waiting(who.front()).front().stamp;
  SteadyTime arrival = now;
  CycleTrigger trigger;
  double waited_s = 0;
  for (const std::size_t i : who) {
    const CycleTurns::Waiting& waiting = turns_.waiting(i).front();
    arrival = std::min(arrival, waiting.arrival);
    if (i == inputs_.size()) {
      trigger.robot = true;
      continue;
    }
    trigger.objects.push_back(i);
    if (!waiting.held_up) continue;
    const auto taken = waiting.give_up - fromSeconds(parameters_.tf_timeout_s);
    waited_s = std::max(waited_s, toSeconds(now - taken));
  }
  turns_.start(who);
  turns_.finish(who, !detect(stamp, trigger, mostS(who), waited_s, arrival));
}

// [s]. Who ran out of time has less of it, so that others do not grow old meanwhile.
double DetectionLoop::mostS(const std::vector<std::size_t>& who) const {
  constexpr double kShareAfterOverrun = 0.25;
  const bool has_others = inputs_.size() > 1 || live_.pair_classes.robot_self;
  const bool overran =
      std::any_of(who.begin(), who.end(), [this](std::size_t i) { return turns_.overran(i); });
  return parameters_.max_cycle_s * (has_others && overran ? kShareAfterOverrun : 1);
}

// Whether it took no longer than it may. That its budget is over is no fault of who triggered it.
bool DetectionLoop::detect(const ros::Time& t, const CycleTrigger& trigger, double most_s,
                           double waited_s, SteadyTime mesh_arrival) {
  const SteadyTime start = time_.steady();
  clock_.startCycle(start);
  sink_->recordStart();
  TransformReport transforms = scene_.prepare(t, trigger, inputs_, lookup_);
  transforms.waited_s = waited_s;
  lookAtMisses(transforms);
  sink_->recordTransforms(transforms);
  CycleReport report = makeReport(t);
  planner_.plan(trigger, scene_, lookup_, &report);
  const SteadyTime budget_end = budget_.deadline(mesh_arrival);
  const SteadyTime deadline = std::min(budget_end, start + fromSeconds(most_s));
  try {
    const Limits limits{deadline, &sources_.requests.stopped()};
    report.result = &runDetector(limits);
    report.backend = detector_->backend();  // it may have fallen back
    report.scene = &scene_.scene();
    noteRejected(&report);
    if (parameters_.containment) noteInside(CycleLimit(limits), &containment_, &report);
    if (report.containment != nullptr) sink_->recordContainment(report);
    Options options = options_;
    options.limits = limits;
    steps_.run(options, parameters_.swept_tolerance_m, &scene_.sceneOfStep(), &report);
    sink_->recordDetectorError(stepProblem(report));
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("detection failed, every pair of the cycle is UNKNOWN: " << error.what());
    sink_->recordDetectorError(error.what());
    report.result = nullptr;
  }
  const bool in_time = !isOutOfTime(report) || deadline == budget_end;
  const SteadyTime detected = time_.steady();
  budget_.record(deadline, detected, sink_->sendCycle(&report, start, mesh_arrival));
  return in_time;
}

// A detector that is given nothing to look at would forget what it started from.
const DetectionResult& DetectionLoop::runDetector(const Limits& limits) {
  if (scene_.looksAtAny()) {
    Options options = options_;
    options.limits = limits;
    options.geometry = options.geometry || sink_->wantsGeometry();
    std::optional<AwakeThread> awake;  // while this one waits for the device
    if (had_many_ && detector_->backend() == "cuda") awake.emplace();
    const DetectionResult& result = detector_->detect(scene_.scene(), options);
    had_many_ = PairSummaries::isOnThreads(result.contacts.size());
    return result;
  }
  nothing_.begin(scene_.scene(), options_, isGuaranteed(options_));
  return nothing_;
}

// Again once a second: reasons change, and an object without a mesh has no cycle to tell them.
void DetectionLoop::listPairs() {
  list_due_ = time_.steady() + std::chrono::seconds(1);
  scene_.markUnknown(whyUnknown());
  CycleReport report = scene_.makeReport(clock_.rosTime(), cycle_);
  sink_->listPairs(&report);
}

void DetectionLoop::heartbeat() {
  clock_.startHeartbeat(time_.steady());
  // ROS time may stand still, and then nothing grows old by it.
  sink_->forgetStates("", "no new mesh");
  std::vector<std::string> why = whyUnknown();
  for (std::string& reason : why) reason = reason.empty() ? "no new mesh" : reason;
  scene_.markUnknown(why);
  CycleReport report = makeReport(clock_.rosTime());
  sink_->sendHeartbeat(&report);
}

// By object; empty: it has a mesh.
std::vector<std::string> DetectionLoop::whyUnknown() const {
  std::vector<std::string> why(inputs_.size(), enabled_ ? "" : "disabled");
  for (std::size_t i = 0; enabled_ && i < why.size(); ++i) {
    inputs_[i].newestAt(clock_.rosTime(), &why[i]);
  }
  return why;
}

// Of the next step, if nothing happens before.
SteadyTime DetectionLoop::wakeTime() const {
  constexpr std::chrono::milliseconds kTransformPeriod(1);  // transforms wake nobody
  const SteadyTime now = time_.steady();
  SteadyTime wake = std::min(clock_.heartbeatDue(), list_due_);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (!turns_.waiting(i).empty()) {
      wake = std::min({wake, turns_.waiting(i).front().give_up, now + kTransformPeriod});
    } else if (!sources_.meshes[i].isEmpty()) {
      wake = std::min(wake, turns_.earliest(i));
    }
  }
  const bool robot_cycles = live_.pair_classes.robot_self && robot_ != nullptr && enabled_;
  return robot_cycles ? std::min(wake, std::max(robots_look_, turns_.earliest(inputs_.size())))
                      : wake;
}

CycleReport DetectionLoop::makeReport(const ros::Time& stamp) {
  CycleReport report = scene_.makeReport(stamp, ++cycle_);
  report.options = options_;
  report.backend = detector_->backend();
  return report;
}

void DetectionLoop::lookAtMisses(const TransformReport& transforms) {
  if (transforms.misses.empty()) return;
  const SteadyTime now = time_.steady();
  for (const TransformReport::Miss& miss : transforms.misses) {
    // A transform from before the jump hides those from after it.
    if (clock_.isLeftover(miss.answer.available, now)) return sources_.transforms.clear();
  }
  // Throttled by wall time: ROS time may stand still.
  if (now - last_warning_ < std::chrono::seconds(1)) return;
  last_warning_ = now;
  ROS_WARN_STREAM(describeMisses(transforms));
}

}  // namespace deformable_contact_monitor
