// The detection thread's work: it takes meshes and requests, and makes cycles. step() is the place
// to start reading.
#include "monitor/cycle/detection_loop.h"

#include <ros/console.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "monitor/input/mesh_adapters.h"
#include "monitor/input/usable_stamp.h"
#include "monitor/rules/rule_texts.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {

constexpr char kNoClock[] = "no clock: use_sim_time is set, and nothing came on /clock";

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
      clock_(parameters.max_mesh_age_s, parameters.budget_ms / 1e3, time_.steady(),
             time_.is_simulated),
      inputs_(sources_.meshes),
      scene_(parameters, detector_->vertexMemory()),
      lookup_(sources_.transforms, parameters.reference_frame),
      scheduler_(maxRatesHz(live_, parameters.objects.size()), inputs_, transformGate()),
      planner_(parameters),
      detection_(*detector_, {parameters.containment, parameters.swept_tolerance_m, true}),
      deletions_(inputs_.size()) {
  noteRules();
}

// The frames follow from the mesh that the request holds, so nothing is searched for.
TransformGate DetectionLoop::transformGate() {
  return {
      [this](std::size_t object, const CycleRequest& request) {
        return lookup_.isWorthWaiting(scene_.awaitedFrames(object, request.stamp, request.mesh));
      },
      [this](std::size_t object, const CycleRequest& request) {
        lookup_.giveUp(scene_.awaitedFrames(object, request.stamp, request.mesh));
      }};
}

SteadyTime DetectionLoop::step() {
  try {
    lookAtTime();
    lookAtRequests();
    warnOfUnknownNames();
    if (time_.steady() >= list_due_) listPairs();
    if (time_.steady() >= show_due_) showUnknown();
    dropLeftovers();
    takeMeshes();
    lookAtRobotsTime();
    const std::vector<std::size_t> turn = scheduler_.next(time_.steady(), clock_.rosTime());
    if (!turn.empty()) takeTurn(turn);
    if (clock_.mustBeat(time_.steady()) && scheduler_.isEmpty()) heartbeat();
    return turn.empty() ? wakeTime() : time_.steady();
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("cycle failed: " << error.what()
                                      << "; see config/docs/console.md#detection-fails");
    sink_->recordDetectorError(error.what());
    return clock_.retryTime(time_.steady());
  }
}

// Without a clock no mesh can have a cycle, because nobody knows how old it is.
void DetectionLoop::lookAtTime() {
  const bool was_there = clock_.isThere();
  const double back_s = clock_.update(time_.ros());
  const std::uint64_t jumps = sources_.transforms.lookAtClock(time_.steady());
  const bool is_noticed = jumps != std::exchange(jumps_, jumps);  // also a jump that is over
  if (clock_.isThere() != was_there) list_due_ = SteadyTime();
  if (!clock_.isThere()) dropMeshes();
  if (back_s > 0 && !is_noticed) sources_.transforms.forget(time_.steady());
  if (back_s == 0 && is_noticed) reset("time jump: the clock went back");
  if (back_s > 0) reset("time jump: the clock went back by " + std::to_string(back_s) + " s");
}

void DetectionLoop::lookAtRequests() {
  const Requests requests = sources_.requests.take();
  epoch_ = requests.epoch;
  if (requests.reset) {
    sources_.transforms.forget(time_.steady());
    reset("reset");
  }
  if (requests.live) applyLive(*requests.live);
  if (requests.allowed_contacts) {
    scene_.setAllowedContacts(*requests.allowed_contacts);
    names_checked_ = false;
    noteRules();
  }
  if (requests.attached) {
    scene_.setAttached(*requests.attached);
    noteRules();
  }
  lookAtRobot();
  applyEnabled(requests);
}

// Publishes the rules again, as they or the pairs that they concern have changed.
void DetectionLoop::noteRules() {
  list_due_ = SteadyTime();
  sink_->recordRules(describeRules(scene_.bodies(), scene_.pairs(), scene_.rules(), scene_.scene(),
                                   scene_.partPairs()));
}

// Prepares the scene, and reports the holds that ended with the meshes of this cycle.
TransformReport DetectionLoop::prepare(const ros::Time& t, const CycleTrigger& trigger) {
  const std::size_t before = scene_.rules().ended_holds.size();
  TransformReport transforms = scene_.prepare(t, trigger, inputs_, lookup_);
  if (scene_.rules().ended_holds.size() == before) return transforms;
  for (const std::string& held : sources_.requests.endHolds(scene_.rules().ended_holds)) {
    ROS_WARN_STREAM("no longer held: " << held << "; see config/README.md#what-may-touch");
  }
  noteRules();
  return transforms;
}

void DetectionLoop::applyLive(const LiveParameters& live) {
  live_ = live;
  setOptions(live, &options_);
  scene_.setMargin(live.margin_m);
  scene_.setPairClasses(live.pair_classes);
  scheduler_.setRates(maxRatesHz(live, inputs_.size()));
  if (!live.pair_classes.needRobotCycles()) scheduler_.drop(inputs_.size());
  robots_look_ = SteadyTime();
  sink_->setMarkerRate(live.marker_rate_hz);
  noteRules();
}

// Builds the scene anew if there is another robot.
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

// Drops every mesh that has no cycle yet.
void DetectionLoop::dropMeshes() {
  for (MeshInput& input : inputs_) {
    input.dropIf([](const ros::Time&) { return true; });
  }
  scheduler_.clear();
}

// Drops every mesh while the monitor is disabled. If it was disabled and enabled since the last
// step, what came before is forgotten all the same.
void DetectionLoop::applyEnabled(const Requests& requests) {
  if (requests.disabled || !requests.enabled) dropMeshes();
  if (requests.enabled != std::exchange(enabled_, requests.enabled)) {
    sink_->recordEnabled(enabled_);
    ROS_INFO_STREAM((enabled_ ? "enabled" : "disabled"));
  }
  if (!requests.disabled) return;
  planner_.forgetAll("it was disabled");
  sink_->forgetStates("", "disabled");
  if (!enabled_) heartbeat();
}

// Waits for the robot, as its links' names are unknown before.
void DetectionLoop::warnOfUnknownNames() {
  if (names_checked_ || (robot_ == nullptr && parameters_.pair_classes.needRobot())) return;
  names_checked_ = true;
  for (const std::string& line :
       describeUnknownNames(parameters_, scene_.rules().allowed, scene_.bodies())) {
    ROS_WARN_STREAM(line << "; see config/README.md#what-may-touch");
  }
}

// Forgets meshes and states, which depend on time as transforms do. Call it once those are
// forgotten: after a jump of the clock the buffer may have some of the new time already.
void DetectionLoop::reset(const std::string& reason) {
  ROS_INFO_STREAM("reset: " << reason);
  for (MeshInput& input : inputs_) input.forget();
  scheduler_.clear();
  robots_stamp_ = ros::Time();
  lookup_.noteReset();
  detector_->reset();
  planner_.forgetAll(reason);
  sink_->forgetStates("", reason);
  sink_->recordReset(reason);
  clock_.startLeftoverWindow(time_.steady());
}

// Drops meshes from before a reset that arrive only now. The condition runs while the input is
// locked, so it asks nobody else.
void DetectionLoop::dropLeftovers() {
  const SteadyTime now = time_.steady();
  for (MeshInput& input : inputs_) {
    input.dropIf([&](const ros::Time& stamp) { return clock_.isLeftover(stamp, now); });
  }
}

// Takes the newest mesh of each object. A rejected mesh asks for a cycle too: its object is UNKNOWN
// in it.
void DetectionLoop::takeMeshes() {
  if (!mayLook()) return;  // the next step drops them
  const SteadyTime now = time_.steady();
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    lookAtDeletion(i);
    if (!scheduler_.mayAdd(i, now)) continue;
    IncomingMesh mesh;
    const Acceptance answer = inputs_[i].take(clock_.rosTime(), &mesh);
    if (answer == Acceptance::kNothing || answer == Acceptance::kDropped) continue;
    if (answer == Acceptance::kJumped) {
      const std::string why = "the stamps of its meshes went back";
      planner_.forget(i, why);
      sink_->forgetStates(parameters_.objects[i].name, why);
    }
    // The stamp of a deletion may be any, and is mostly zero.
    const ros::Time stamp = mesh.is_deletion
                                ? clock_.rosTime()
                                : cycleStamp(mesh.stamp(), answer == Acceptance::kRejected);
    scheduler_.add(i, {std::move(mesh), stamp, clock_.startWait(parameters_.tf_timeout_s, now)},
                   now);
  }
}

// Ends the grace of a deletion that no mesh has followed.
void DetectionLoop::lookAtDeletion(std::size_t object) {
  const SteadyTime now = time_.steady();
  const std::optional<SteadyTime> at = inputs_[object].deletedAt();
  if (!at) return;
  Wait& wait = deletions_[object];
  if (wait.start != *at || wait.length == SteadyTime::duration()) {
    wait = clock_.startWait(kDeletionGraceS, *at);
  }
  if (wait.isOver(now, clock_.rosTime())) inputs_[object].endGrace();
}

// A rejected mesh may have a senseless stamp, but its object must become UNKNOWN at once.
ros::Time DetectionLoop::cycleStamp(const ros::Time& stamp, bool rejected) const {
  const ros::Time& now = clock_.rosTime();
  if (!rejected || (now.isZero() && !stamp.isZero())) return stamp;
  const double age_s = secondsBetween(now, stamp);
  return age_s >= 0 && age_s <= parameters_.max_mesh_age_s ? stamp : now;
}

// Requests a cycle of the robot's links with one another and with rigid objects, when one is due.
void DetectionLoop::lookAtRobotsTime() {
  const std::size_t robot = inputs_.size();
  const SteadyTime now = time_.steady();
  if (!live_.pair_classes.needRobotCycles() || robot_ == nullptr || !mayLook()) return;
  if (scheduler_.hasRequest(robot) || !scheduler_.mayAdd(robot, now) || now < robots_look_) return;
  robots_look_ = now + fromSeconds(1 / live_.robot_rate_hz);
  const std::optional<ros::Time> stamp = nextRobotsStamp();
  if (!stamp) return;
  CycleRequest request;
  request.mesh.arrival = now;
  request.stamp = *stamp;
  request.wait.start = now;
  scheduler_.add(robot, std::move(request), now);
}

// Returns the stamp of the robot's next cycle; nothing if that stamp had its cycle. It is the
// newest stamp at which all links have a pose. If that stamp is too old or ahead of the clock, it
// is the present time, and the cycle says which transforms are missing. A frame that has stopped is
// waited for until the states are almost too old.
std::optional<ros::Time> DetectionLoop::nextRobotsStamp() {
  constexpr double kLooks = 1.5;
  const std::vector<std::string> frames = scene_.framesOfRobotCycle();
  if (frames.empty()) return std::nullopt;
  const ros::Time now = clock_.rosTime();
  const double max_age_s = parameters_.max_mesh_age_s;
  const double patience_s = std::max(max_age_s - kLooks / live_.robot_rate_hz, max_age_s / 2);
  auto newest = lookup_.newestCommon(frames, max_age_s, now);
  if (newest && *newest <= robots_stamp_ && secondsBetween(now, *newest) > patience_s) {
    newest = lookup_.newestCommon(frames, max_age_s, now, *newest);
  }
  if (!newest || newest->isZero()) return now.isZero() ? std::nullopt : std::optional(now);
  const double age_s = now.isZero() ? 0 : secondsBetween(now, *newest);
  if (age_s > max_age_s || age_s < -kClockToleranceS) return now;
  if (*newest <= robots_stamp_) return std::nullopt;
  robots_stamp_ = *newest;
  return newest;
}

// Starts the cycle of these objects, or of the robot. It counts from the arrival of their first
// mesh, by simulated time as far as the mesh has waited, which a slow simulator prolongs.
void DetectionLoop::takeTurn(const std::vector<std::size_t>& who) {
  const SteadyTime now = time_.steady();
  const ros::Time stamp = scheduler_.first(who.front()).stamp;
  SteadyTime arrival = now;
  CycleTrigger trigger;
  double waited_s = 0;
  for (const std::size_t i : who) {
    const CycleRequest& request = scheduler_.first(i);
    const SteadyTime::duration wait = request.wait.passed(now, clock_.rosTime());
    arrival = std::min(arrival, now - wait - (request.wait.start - request.mesh.arrival));
    if (i == inputs_.size()) {
      trigger.robot = true;
      continue;
    }
    trigger.objects.push_back(i);
    if (request.waits_for_transforms) waited_s = std::max(waited_s, toSeconds(wait));
  }
  scheduler_.start(who);
  scheduler_.finish(who, !detect(stamp, trigger, mostS(who), waited_s, arrival));
}

// Returns the time that the cycle may take [s]. It is less after a cycle that ran out of time, so
// that the meshes of the others do not become too old meanwhile.
double DetectionLoop::mostS(const std::vector<std::size_t>& who) const {
  constexpr double kShareAfterOverrun = 0.25;
  const bool has_others = inputs_.size() > 1 || live_.pair_classes.needRobotCycles();
  const bool overran =
      std::any_of(who.begin(), who.end(), [this](std::size_t i) { return scheduler_.overran(i); });
  return parameters_.max_cycle_s * (has_others && overran ? kShareAfterOverrun : 1);
}

// Makes one cycle, and returns whether it ended within `most_s` [s]. A cycle that budget_ms ended
// counts as in time, because it used no time that belongs to other objects.
bool DetectionLoop::detect(const ros::Time& t, const CycleTrigger& trigger, double most_s,
                           double waited_s, SteadyTime mesh_arrival) {
  const SteadyTime start = time_.steady();
  clock_.startCycle(start);
  sink_->recordStart();
  TransformReport transforms = prepare(t, trigger);
  transforms.waited_s = waited_s;
  lookAtTransforms(transforms);
  sink_->recordTransforms(transforms);
  const SteadyTime budget_end = clock_.deadline(mesh_arrival);
  const SteadyTime deadline = std::min(budget_end, start + fromSeconds(most_s));
  const CycleReport report = findContacts(t, trigger, {deadline, &sources_.requests.stopped()});
  const bool in_time = !isOutOfTime(report) || deadline == budget_end;
  const SteadyTime detected = time_.steady();
  const SteadyTime published = sink_->sendCycle(report, start, mesh_arrival);
  planner_.commit();
  clock_.recordCycle(deadline, detected, published);
  return in_time;
}

// Makes the report of a cycle whose scene is prepared. A detection that fails is reported, too.
CycleReport DetectionLoop::findContacts(const ros::Time& t, const CycleTrigger& trigger,
                                        const Limits& limits) {
  CycleReport report = makeReport(t);
  report.motion = parameters_.motion;
  report.sweeps = planner_.plan(trigger, scene_, lookup_, report);
  try {
    detection_.run(limits, sink_->wantsGeometry(), &scene_.sceneOfStep(), &report);
    sink_->recordDetectorError(stepProblem(report));
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("detection failed, every pair of the cycle is UNKNOWN: "
                     << error.what() << "; see config/docs/console.md#detection-fails");
    sink_->recordDetectorError(error.what());
  }
  report.now = time_.ros();
  const bool is_noticed = sources_.transforms.lookAtClock(time_.steady()) != jumps_;
  if (clock_.backS(report.now) == 0 && !is_noticed) return report;
  // The next step resets everything. Until then, nothing of the time before is said to be known.
  for (BodyStatus& body : report.bodies) {
    if (body.triggered) body.unknown_because = "time jump: the clock went back during the cycle";
  }
  return report;
}

// Lists all pairs, once a second: the reasons for UNKNOWN change, and an object without a mesh has
// no cycle that could report them.
void DetectionLoop::listPairs() {
  list_due_ = time_.steady() + std::chrono::seconds(1);
  scene_.markUnknown(whyUnknown());
  CycleReport report = scene_.makeReport(time_.ros(), cycle_);
  report.now = report.header.stamp;
  sink_->listPairs(report);
}

// Objects without a new mesh have no cycle in which they would be drawn.
void DetectionLoop::showUnknown() {
  constexpr std::chrono::milliseconds kPeriod(250);  // see kUnknownLifetimeS
  show_due_ = time_.steady() + kPeriod;
  const std::vector<std::string> why = whyUnknown();
  if (std::all_of(why.begin(), why.end(), [](const auto& reason) { return reason.empty(); })) {
    return;
  }
  scene_.markUnknown(why);
  CycleReport report = scene_.makeReport(clock_.rosTime(), cycle_);
  report.scene = &scene_.scene();
  for (BodyStatus& body : report.bodies) body.triggered = !body.unknown_because.empty();
  sink_->showUnknown(report);
}

// Publishes that nothing is known, so that silence is not mistaken for "no contact".
void DetectionLoop::heartbeat() {
  clock_.startHeartbeat(time_.steady());
  // If ROS time stands still, no state becomes too old, so all states are forgotten here.
  sink_->forgetStates("", clock_.isThere() ? "no new mesh" : kNoClock);
  std::vector<std::string> why = whyUnknown();
  for (std::string& reason : why) reason = reason.empty() ? "no new mesh" : reason;
  scene_.markUnknown(why);
  sink_->sendHeartbeat(makeReport(clock_.rosTime()));
}

// Returns why each object is UNKNOWN; empty: it has a mesh.
std::vector<std::string> DetectionLoop::whyUnknown() const {
  const char* const of_all = !enabled_ ? "disabled" : clock_.isThere() ? "" : kNoClock;
  std::vector<std::string> why(inputs_.size(), of_all);
  for (std::size_t i = 0; mayLook() && i < why.size(); ++i) {
    inputs_[i].newestAt(clock_.rosTime(), &why[i]);
  }
  return why;
}

// Returns when the next step is due, unless something wakes the thread before.
SteadyTime DetectionLoop::wakeTime() const {
  constexpr std::chrono::milliseconds kTransformPeriod(1);  // new transforms wake nobody
  const SteadyTime now = time_.steady();
  SteadyTime wake = std::min(list_due_, show_due_);
  if (scheduler_.isEmpty()) wake = std::min(wake, clock_.heartbeatDue(now));
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (scheduler_.hasRequest(i)) {
      wake = std::min(wake, now + kTransformPeriod);
    } else if (inputs_[i].hasWaiting()) {
      wake = std::min(wake, scheduler_.earliest(i));
    }
    const bool is_deleted = inputs_[i].deletedAt() && !inputs_[i].hasWaiting();
    if (is_deleted) wake = std::min(wake, deletions_[i].nextLook(now));
  }
  const bool robot_cycles = live_.pair_classes.needRobotCycles() && robot_ != nullptr && mayLook();
  return robot_cycles ? std::min(wake, std::max(robots_look_, scheduler_.earliest(inputs_.size())))
                      : wake;
}

CycleReport DetectionLoop::makeReport(const ros::Time& stamp) {
  CycleReport report = scene_.makeReport(stamp, ++cycle_);
  report.epoch = epoch_;
  report.options = options_;
  report.backend = detector_->backend();
  report.now = time_.ros();
  return report;
}

// Warns of bodies without a transform. ROS_WARN_THROTTLE would not do: ROS time may stand still.
void DetectionLoop::lookAtTransforms(const TransformReport& transforms) {
  const auto surroundings = [this] {
    return describeSurroundings(sources_.transforms, sources_.transform_publishers);
  };
  const auto said = transform_warnings_.look(transforms, surroundings, time_.steady());
  for (const std::string& line : said.news) ROS_INFO_STREAM(line);
  for (const std::string& line : said.warnings) {
    ROS_WARN_STREAM(line << "; see config/docs/console.md#no-transform");
  }
}

}  // namespace deformable_contact_monitor
