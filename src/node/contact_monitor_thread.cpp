// The monitor: its detection thread.
#include <algorithm>
#include <utility>

#include "node/contact_monitor.h"
#include "node/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::chrono::seconds kHeartbeatPeriod(1);
// After a time jump, messages from before it may still be under way.
constexpr std::chrono::milliseconds kLeftoverWindow(500);
constexpr double kClockToleranceS = 0.1;  // clocks of two machines differ a little

std::chrono::steady_clock::duration seconds(double s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(s));
}

}  // namespace

void ContactMonitor::run() {
  heartbeat_due_ = Clock::now() + kHeartbeatPeriod;
  wake_at_ = Clock::now();
  while (true) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      wake_.wait_until(lock, wake_at_, [this] { return woken_; });
      woken_ = false;
    }
    if (stop_) return;
    try {
      step();
    } catch (const std::exception& error) {  // out of memory, say: the next mesh may be smaller
      ROS_ERROR_STREAM("cycle failed: " << error.what());
      diagnostics_.recordDetectorError(error.what());
      wake_at_ = Clock::now() + kHeartbeatPeriod;
    }
  }
}

// At most one cycle, so that requests and the clock are looked at in between.
void ContactMonitor::step() {
  checkClock();
  applyRequests();
  applyRobot();
  applyEnabled();
  warnOfUnknownNames();
  dropLeftovers();
  MeshInput* const input = nextInput();
  if (input != nullptr && Clock::now() >= earliest_cycle_) cycleFor(input);
  if (Clock::now() >= heartbeat_due_) heartbeat();
  wake_at_ = heartbeat_due_;
  if (nextInput() != nullptr) wake_at_ = std::min(wake_at_, earliest_cycle_);
}

void ContactMonitor::checkClock() {
  const ros::Time now = ros::Time::now();
  const double back_s = secondsBetween(last_now_, now);
  last_now_ = now;
  if (back_s > kClockToleranceS) {
    reset("time jump: the clock went back by " + std::to_string(back_s) + " s");
  }
}

void ContactMonitor::applyRequests() {
  Requests requests;
  AllowedContacts allowed;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::swap(requests, requests_);
    if (requests.allowed_contacts) allowed = allowed_;
  }
  if (requests.reset) reset("reset");
  if (!requests.allowed_contacts) return;
  scene_.setAllowedContacts(allowed);
  names_checked_ = false;
}

void ContactMonitor::applyEnabled() {
  const bool enabled = enabled_;
  if (!enabled) {
    for (const auto& input : inputs_) input->dropWaiting();
  }
  if (enabled == was_enabled_) return;
  was_enabled_ = enabled;
  diagnostics_.recordEnabled(enabled);
  ROS_INFO_STREAM((enabled ? "enabled" : "disabled"));
  if (!enabled) {
    publisher_.endContacts("disabled");
    heartbeat();
  }
}

void ContactMonitor::applyRobot() {
  const std::shared_ptr<const RobotGeometry> newest = robot_source_.newest();
  if (newest == robot_) return;
  const bool changed = robot_ != nullptr;
  robot_ = newest;
  scene_.setRobot(*robot_);
  names_checked_ = false;
  detector_->reset();
  if (changed) publisher_.endContacts("robot changed");
  publisher_.publishRobot(*robot_);
}

void ContactMonitor::reset(const std::string& reason) {
  ROS_INFO_STREAM("reset: " << reason);
  for (const auto& input : inputs_) input->forget();
  buffer_.clear();
  detector_->reset();
  publisher_.endContacts(reason);
  diagnostics_.recordReset(reason);
  settled_ = Clock::now() + kLeftoverWindow;
}

MeshInput* ContactMonitor::nextInput() const {
  MeshInput* next = nullptr;
  ros::Time earliest;
  for (const auto& input : inputs_) {
    const std::optional<ros::Time> stamp = input->waitingStamp();
    if (!stamp || (next != nullptr && *stamp >= earliest)) continue;
    next = input.get();
    earliest = *stamp;
  }
  return next;
}

bool ContactMonitor::isAhead(const ros::Time& stamp) const {
  return secondsBetween(stamp, last_now_) > kClockToleranceS;
}

void ContactMonitor::dropLeftovers() {
  if (Clock::now() >= settled_) return;
  for (const auto& input : inputs_) {
    const std::optional<ros::Time> stamp = input->waitingStamp();
    if (stamp && isAhead(*stamp)) input->dropWaiting();
  }
}

void ContactMonitor::cycleFor(MeshInput* input) {
  if (input->waitingJumpsBack()) reset("time jump: mesh stamps went back");
  const ros::Time stamp = input->waitingStamp().value_or(last_now_);
  const Clock::time_point arrival = input->waitingSince();
  bool anything_new = false;
  for (const auto& other : inputs_) {
    if (other->waitingStamp() == stamp) anything_new |= other->take(last_now_);
  }
  // A refused mesh may have a senseless stamp, yet its object must become UNKNOWN at once.
  const bool sensible = !stamp.isZero() && (last_now_.isZero() || stamp <= last_now_ ||
                                            input->counters().refusal.empty());
  if (anything_new) detectAndPublish(sensible ? stamp : last_now_, arrival);
}

void ContactMonitor::detectAndPublish(const ros::Time& t, Clock::time_point mesh_arrival) {
  const Clock::time_point start = Clock::now();
  earliest_cycle_ = start;
  if (parameters_.max_rate_hz > 0) earliest_cycle_ += seconds(1 / parameters_.max_rate_hz);
  // Silence is no news until the newest mesh is too old.
  heartbeat_due_ =
      start + std::max<Clock::duration>(kHeartbeatPeriod, seconds(parameters_.max_mesh_age_s));

  const TransformReport transforms = scene_.prepare(t, inputs_, lookup_);
  warnOf(transforms);
  diagnostics_.recordTransforms(transforms);
  CycleReport report = makeReport(t);
  try {
    report.result = &detector_->detect(scene_.scene(), parameters_.detector);
    report.backend = detector_->backend();  // it may have fallen back
    report.scene = &scene_.scene();
    diagnostics_.recordDetectorError("");
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("detection failed, every pair is UNKNOWN: " << error.what());
    diagnostics_.recordDetectorError(error.what());
  }
  const CyclePublisher::Latest sent = publisher_.publish(&report);
  const auto since = [](Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  };
  const double latency_s = since(mesh_arrival);
  publisher_.publishMarkers(report);
  diagnostics_.recordCycle(report, *sent.contacts, since(start), latency_s);
}

void ContactMonitor::heartbeat() {
  heartbeat_due_ = Clock::now() + kHeartbeatPeriod;
  if (ros::Time::isSimTime() && last_now_.isZero()) {
    ROS_WARN("use_sim_time is set: waiting for /clock");
  }
  std::vector<std::string> why(inputs_.size(), was_enabled_ ? "no new mesh" : "disabled");
  for (std::size_t i = 0; was_enabled_ && i < why.size(); ++i) {
    inputs_[i]->newestAt(last_now_, &why[i]);
  }
  scene_.markUnknown(why);
  CycleReport report = makeReport(last_now_);
  const CyclePublisher::Latest sent = publisher_.publish(&report);
  publisher_.publishMarkers(report);
  diagnostics_.recordCycle(report, *sent.contacts, 0, 0);
}

CycleReport ContactMonitor::makeReport(const ros::Time& stamp) {
  CycleReport report;
  report.header.stamp = stamp;
  report.header.frame_id = parameters_.reference_frame;
  report.cycle = ++cycle_;
  report.bodies = scene_.bodies();
  report.pairs = scene_.pairs();
  report.options = parameters_.detector;
  report.backend = detector_->backend();
  return report;
}

void ContactMonitor::warnOf(const TransformReport& transforms) {
  constexpr std::size_t kShown = 5;
  if (transforms.misses.empty()) return;
  for (const TransformReport::Miss& miss : transforms.misses) {
    // A transform from before the jump hides those from after it.
    if (Clock::now() < settled_ && isAhead(miss.answer.available)) {
      buffer_.clear();
      return;
    }
  }
  // Throttled by wall time: ROS time may stand still.
  if (Clock::now() - last_warning_ < std::chrono::seconds(1)) return;
  last_warning_ = Clock::now();
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, transforms.misses.size()); ++i) {
    const TransformReport::Miss& miss = transforms.misses[i];
    text += "\n  " + miss.body + ": " + miss.answer.problem;
  }
  if (transforms.misses.size() > kShown) {
    text += "\n  and " + std::to_string(transforms.misses.size() - kShown) + " more";
  }
  ROS_WARN_STREAM("UNKNOWN for want of a transform:" << text);
}

void ContactMonitor::warnOfUnknownNames() {
  if (names_checked_ || (robot_ == nullptr && parameters_.pair_classes.needRobot())) return;
  names_checked_ = true;
  for (const AllowedContact& rule : scene_.allowedContacts().rules()) {
    for (const std::string& name : {rule.body_a, rule.body_b}) {
      const auto is_it = [&name](const BodyStatus& body) { return body.name == name; };
      if (name == "*" || std::any_of(scene_.bodies().begin(), scene_.bodies().end(), is_it))
        continue;
      ROS_WARN_STREAM("allowed contacts name '" << name << "', which is no link or object");
    }
  }
}

}  // namespace deformable_contact_monitor
