// The detection thread's work: meshes and requests in, cycles out.
#include "node/detection_loop.h"

#include <ros/console.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "node/loop_warnings.h"

namespace deformable_contact_monitor {

using SteadyTime = CycleClock::SteadyTime;

DetectionLoop::DetectionLoop(const MonitorParameters& parameters, LoopSources sources,
                             LoopTime time, std::unique_ptr<Detector> detector,
                             std::unique_ptr<CycleSink> sink)
    : parameters_(parameters),
      sources_(std::move(sources)),
      time_(std::move(time)),
      detector_(std::move(detector)),
      sink_(std::move(sink)),
      clock_(parameters.max_rate_hz, parameters.max_mesh_age_s, time_.steady()),
      inputs_(makeMeshInputs(parameters)),
      scene_(parameters),
      lookup_(sources_.transforms, parameters.reference_frame, parameters.tf_timeout_s) {
  ROS_INFO_STREAM("monitoring " << inputs_.size() << " object(s) in frame '"
                                << parameters_.reference_frame << "' on the "
                                << detector_->backend());
}

SteadyTime DetectionLoop::step() {
  try {
    lookAtTime();
    lookAtRequests();
    warnOfUnknownNames();
    dropLeftovers();
    const std::optional<ros::Time> stamp = earliestWaiting();
    if (stamp && clock_.mayCycle(time_.steady())) takeAndDetect(*stamp);
    if (clock_.mustBeat(time_.steady())) heartbeat();
    return clock_.wakeTime(earliestWaiting().has_value());
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

void DetectionLoop::lookAtRequests() {
  const Requests requests = sources_.requests.take();
  if (requests.reset) reset("reset");
  if (requests.allowed_contacts) {
    scene_.setAllowedContacts(*requests.allowed_contacts);
    names_checked_ = false;
  }
  lookAtRobot();
  applyEnabled(requests.enabled);
}

void DetectionLoop::lookAtRobot() {
  const std::shared_ptr<const RobotGeometry> newest = sources_.newest_robot();
  if (newest == robot_) return;
  const bool changed = robot_ != nullptr;
  robot_ = newest;
  scene_.setRobot(*robot_);
  names_checked_ = false;
  detector_->reset();
  if (changed) sink_->endContacts("robot changed");
  sink_->sendRobot(*robot_);
}

void DetectionLoop::applyEnabled(bool enabled) {
  if (!enabled) {
    for (MeshMailbox& mailbox : sources_.meshes) {
      mailbox.dropIf([](const ros::Time&) { return true; });
    }
  }
  if (enabled == enabled_) return;
  enabled_ = enabled;
  sink_->recordEnabled(enabled);
  ROS_INFO_STREAM((enabled ? "enabled" : "disabled"));
  if (!enabled) {
    sink_->endContacts("disabled");
    heartbeat();
  }
}

void DetectionLoop::warnOfUnknownNames() {
  if (names_checked_ || (robot_ == nullptr && parameters_.pair_classes.needRobot())) return;
  names_checked_ = true;
  for (const std::string& name : unknownNames(scene_.allowedContacts(), scene_.bodies())) {
    ROS_WARN_STREAM("allowed contacts name '" << name << "', which is no link or object");
  }
}

void DetectionLoop::reset(const std::string& reason) {
  ROS_INFO_STREAM("reset: " << reason);
  for (MeshInput& input : inputs_) input.forget();
  sources_.transforms.clear();
  detector_->reset();
  sink_->endContacts(reason);
  sink_->recordReset(reason);
  clock_.startLeftoverWindow(time_.steady());
}

void DetectionLoop::dropLeftovers() {
  const SteadyTime now = time_.steady();
  for (MeshMailbox& mailbox : sources_.meshes) {
    mailbox.dropIf([&](const ros::Time& stamp) { return clock_.isLeftover(stamp, now); });
  }
}

std::optional<ros::Time> DetectionLoop::earliestWaiting() const {
  std::optional<ros::Time> earliest;
  for (const MeshMailbox& mailbox : sources_.meshes) {
    const std::optional<ros::Time> stamp = mailbox.waitingStamp();
    if (stamp && (!earliest || *stamp < *earliest)) earliest = stamp;
  }
  return earliest;
}

// Meshes of one stamp share a cycle. Where a newer mesh has come since the stamp was read, there is
// nothing to take: the newer one has its turn in the next step.
void DetectionLoop::takeAndDetect(const ros::Time& stamp) {
  const ros::Time now = clock_.rosTime();
  std::vector<std::pair<std::size_t, ArrivedMesh>> taken;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    std::optional<ArrivedMesh> mesh = sources_.meshes[i].takeAt(stamp);
    if (mesh) taken.emplace_back(i, std::move(*mesh));
  }
  if (taken.empty()) return;
  const MeshInput& first = inputs_[taken.front().first];
  if (first.jumpsBack(stamp)) reset("time jump: mesh stamps went back");
  bool anything_new = false;
  for (const auto& [object, mesh] : taken) {
    anything_new |= inputs_[object].accept(mesh, now);
    sink_->recordMesh(object, inputs_[object].counters());
  }
  // A refused mesh may have a senseless stamp, yet its object must become UNKNOWN at once.
  const bool sensible =
      !stamp.isZero() && (now.isZero() || stamp <= now || first.counters().refusal.empty());
  if (anything_new) detect(sensible ? stamp : now, taken.front().second.arrival);
}

void DetectionLoop::detect(const ros::Time& t, SteadyTime mesh_arrival) {
  const SteadyTime start = time_.steady();
  clock_.startCycle(start);
  const TransformReport transforms = scene_.prepare(t, inputs_, lookup_);
  lookAtMisses(transforms);
  sink_->recordTransforms(transforms);
  CycleReport report = makeReport(t);
  try {
    report.result = &detector_->detect(scene_.scene(), parameters_.detector);
    report.backend = detector_->backend();  // it may have fallen back
    report.scene = &scene_.scene();
    sink_->recordDetectorError("");
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("detection failed, every pair is UNKNOWN: " << error.what());
    sink_->recordDetectorError(error.what());
  }
  sink_->sendCycle(&report, start, mesh_arrival);
}

void DetectionLoop::heartbeat() {
  clock_.startHeartbeat(time_.steady());
  const ros::Time now = clock_.rosTime();
  // Without use_sim_time, ROS time is never zero.
  if (now.isZero()) ROS_WARN("use_sim_time is set: waiting for /clock");
  std::vector<std::string> why(inputs_.size(), enabled_ ? "no new mesh" : "disabled");
  for (std::size_t i = 0; enabled_ && i < why.size(); ++i) inputs_[i].newestAt(now, &why[i]);
  scene_.markUnknown(why);
  CycleReport report = makeReport(now);
  sink_->sendHeartbeat(&report);
}

CycleReport DetectionLoop::makeReport(const ros::Time& stamp) {
  CycleReport report = scene_.makeReport(stamp, ++cycle_);
  report.options = parameters_.detector;
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
