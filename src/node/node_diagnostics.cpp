// Publishes the monitor's health on /diagnostics. Each describe function fills one status.
#include "node/node_diagnostics.h"

#include <algorithm>

namespace deformable_contact_monitor {

using diagnostic_msgs::DiagnosticStatus;

NodeDiagnostics::NodeDiagnostics(const MonitorParameters& parameters, const MeshInputs& meshes,
                                 const RobotSource& robot, const ros::NodeHandle& node,
                                 const ros::NodeHandle& private_node)
    : parameters_(parameters),
      meshes_(meshes),
      robot_(robot),
      updater_(node, private_node, private_node.getNamespace()),
      max_rate_hz_(parameters.max_rate_hz),
      trade_(parameters.detector.tolerance_m, parameters.budget_ms / 1e3) {
  for (const ObjectParameters& object : parameters_.objects) {
    watches_.emplace_back(object.required, parameters_.max_mesh_age_s,
                          parameters_.diagnostic_min_rate_hz, Clock::now());
  }
  updater_.setHardwareID("none");
  add("status", [this](Status& status) { describeStatus(status); });
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    add("mesh:" + parameters_.objects[i].name,
        [this, i](Status& status) { describeMesh(i, status); });
  }
  add("tf", [this](Status& status) { transforms_.describe(status, Clock::now()); });
  add("timing", [this](Status& status) { describeTiming(status); });
  add("output", [this](Status& status) { describeOutput(status); });
  add("allowed", [this](Status& status) { describeAllowed(status); });
  if (parameters_.motion == Motion::kSwept) {
    add("motion", [this](Status& status) { motion_.describe(status); });
  }
  if (tradesAccuracy(parameters_)) {
    add("trade", [this](Status& status) { trade_.describe(status); });
  }
}

void NodeDiagnostics::add(const std::string& name, const std::function<void(Status&)>& describe) {
  updater_.add(name, [this, describe](Status& status) {
    const std::lock_guard<std::mutex> lock(mutex_);
    describe(status);
  });
}

// The record functions only copy under the mutex, so they never delay the detection thread, which
// calls most of them. describe functions run in the callbacks' thread.
void NodeDiagnostics::recordStart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  timing_.start(Clock::now());
}

// A cycle that runs for longer than this is the likely reason; otherwise no mesh came.
std::string NodeDiagnostics::whySilent() const {
  constexpr double kLongS = 0.1;
  const std::lock_guard<std::mutex> lock(mutex_);
  const double running_s = timing_.runsFor(Clock::now());
  if (running_s < kLongS) return "no new mesh within max_mesh_age_s";
  return "busy: a cycle has been running for " + std::to_string(running_s) + " s";
}

// Keeps what the status `output` shows, and not the pairs, of which there may be millions. With a
// tolerance, `guaranteed` means that the other settings lose no contact.
void NodeDiagnostics::recordCycle(const CycleReport& report, const ContactArray& sent,
                                  const CycleTimes& times) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++cycles_;
  timing_.end(report, times);
  motion_.record(report);
  backend_ = report.backend;
  if (report.result) {
    const std::uint64_t mib = report.result->memory_bytes >> 20U;
    device_memory_mib_ = (report.result->memory_is_whole ? "" : "at least ") + std::to_string(mib);
    if (mib == 0) device_memory_mib_.clear();  // the CPU ran
  }
  output_ = ContactArray();
  output_.pair_count = sent.pair_count;
  output_.complete = sent.complete;
  output_.truncated = sent.truncated;
  output_.undecided = sent.undecided;
  output_.rejected_triangles = sent.rejected_triangles;
  output_.skipped = sent.skipped;
  output_.age = sent.age;
  output_.timed_out = sent.timed_out;
  output_.guaranteed = sent.guaranteed || (sent.tolerance > 0 && isGuaranteed(report.options));
}

void NodeDiagnostics::recordTrade(const CycleReport& report, double answer_s) {
  if (!tradesAccuracy(parameters_)) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  trade_.record(report, answer_s);
}

void NodeDiagnostics::recordAnomaly(const std::string& object, const std::string& anomaly) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    if (parameters_.objects[i].name == object) watches_[i].setAnomaly(anomaly);
  }
}

std::pair<std::string, std::string> NodeDiagnostics::meshProblems(std::size_t object) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {meshes_[object].counters().problem, watches_[object].anomaly()};
}

bool NodeDiagnostics::isEnabled() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return enabled_;
}

void NodeDiagnostics::recordTransforms(const TransformReport& report) {
  const std::lock_guard<std::mutex> lock(mutex_);
  transforms_.record(report, Clock::now());
}

void NodeDiagnostics::recordReset(const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++resets_;
  last_reset_ = reason;
}

// Shows the robot, the backend, and errors of both. mergeSummary() keeps the worst
// level and joins the texts of all problems.
void NodeDiagnostics::describeStatus(Status& status) const {
  status.summary(DiagnosticStatus::OK, "monitoring");
  if (!enabled_) status.summary(DiagnosticStatus::WARN, "disabled by ~set_enabled");
  if (ros::Time::now().isZero()) {
    status.mergeSummary(DiagnosticStatus::ERROR,
                        "no clock: use_sim_time is set, and nothing came on /clock");
  }
  if (parameters_.pair_classes.needRobot()) {
    std::size_t triangles = 0;
    std::string unusable;
    const auto robot = robot_.newest();
    for (const LinkGeometry& link : robot ? robot->links : std::vector<LinkGeometry>()) {
      triangles += link.mesh.triangleCount();
      if (link.problem.empty()) continue;
      unusable += (unusable.empty() ? "" : ", ") + link.link;
      status.add("link " + link.link, link.problem);
    }
    status.add("robot links", robot ? robot->links.size() : 0);
    status.add("robot triangles", triangles);
    for (const std::string& link : robot ? robot->unmonitored_links : std::vector<std::string>()) {
      status.add("link " + link, robot->kind == GeometryKind::kVisual
                                     ? "not monitored: collision but no visual geometry"
                                     : "not monitored: visual but no collision geometry");
    }
    if (!robot) status.mergeSummary(DiagnosticStatus::ERROR, "no robot received yet");
    if (!unusable.empty()) {
      status.mergeSummary(DiagnosticStatus::WARN, "links without usable geometry: " + unusable);
    }
    if (!robot_.problem().empty()) {
      status.mergeSummary(DiagnosticStatus::ERROR, "link meshes rejected: " + robot_.problem());
    }
  }
  if (!detector_error_.empty()) {
    status.mergeSummary(DiagnosticStatus::ERROR, "detection failed: " + detector_error_);
  }
  const BackendStatus backend = backendStatus(parameters_.backend, backend_state_);
  if (backend.level != DiagnosticStatus::OK) status.mergeSummary(backend.level, backend.summary);
  if (is_unregistered_) {
    status.mergeSummary(DiagnosticStatus::ERROR,
                        "this node is no longer registered with the ROS master: restart it");
  }
  status.add("backend", backend_);
  status.add("backend asked for", toString(parameters_.backend));
  status.add("backend problem", backend_state_.problem);
  if (!device_memory_mib_.empty()) status.add("device memory [MiB]", device_memory_mib_);
  status.add("cycles", cycles_);
  status.add("resets", resets_);
  status.add("last reset", last_reset_);
  if (parameters_.containment) status.add("not closed", open_bodies_);
}

void NodeDiagnostics::describeMesh(std::size_t object, Status& status) {
  watches_[object].describe(status,
                            {meshes_[object].counters(), meshes_[object].rivals(Clock::now()),
                             ros::Time::now(), ros::Time::isSimTime(), enabled_, max_rate_hz_},
                            Clock::now());
}

// The fastest object decides how long a cycle may take.
void NodeDiagnostics::describeTiming(Status& status) {
  double period_s = 0;
  for (const MeshWatch& watch : watches_) {
    if (watch.periodS() == 0) continue;
    period_s = period_s == 0 ? watch.periodS() : std::min(period_s, watch.periodS());
  }
  timing_.describe(status, Clock::now(), period_s);
}

// Tells whether the newest ~contacts is complete, and why not.
void NodeDiagnostics::describeOutput(Status& status) const {
  if (cycles_ == 0) {
    status.summary(DiagnosticStatus::WARN, "nothing published yet");
    return;
  }
  // Pairs of triangles that a tolerance leaves out are no fault, because it was asked for.
  const bool is_whole = output_.guaranteed && output_.skipped.empty() && !output_.truncated &&
                        !output_.timed_out && output_.rejected_triangles == 0;
  status.summary(DiagnosticStatus::OK, output_.complete ? "complete" : "within tolerance_m");
  if (!output_.complete && !is_whole) status.summary(DiagnosticStatus::WARN, "not complete");
  for (const std::string& skipped : output_.skipped) status.add("skipped", skipped);
  status.add("pairs", output_.pair_count);
  status.add("truncated", output_.truncated != 0 ? "true" : "false");
  status.add("undecided", output_.undecided);
  status.add("rejected triangles", output_.rejected_triangles);
  status.add("age [s]", output_.age.toSec());
}

// Shows the rules in force by their source, attached objects, and each body's margin and partners.
void NodeDiagnostics::describeAllowed(Status& status) const {
  status.summaryf(DiagnosticStatus::OK, "%zu of %zu pairs may touch", rules_.allowedPairs(),
                  rules_.pairs);
  const std::string problem = robot_.srdfProblem();
  if (!problem.empty()) {
    status.mergeSummary(DiagnosticStatus::ERROR, "the SRDF is not used: " + problem);
  }
  for (const RuleSource source :
       {RuleSource::kParameters, RuleSource::kService, RuleSource::kAttached, RuleSource::kSrdf}) {
    const auto i = static_cast<std::size_t>(source);
    status.addf(std::string("rules: ") + toString(source), "%zu, for %zu pairs", rules_.rules[i],
                rules_.allowed_pairs[i]);
  }
  for (const std::string& held : rules_.attached) status.add("held", held);
  for (const std::string& ended : rules_.ended_holds) {
    status.mergeSummary(DiagnosticStatus::WARN, "no longer held: " + ended);
  }
  for (const auto& [body, rules] : rules_.bodies) status.add(body, rules);
}

}  // namespace deformable_contact_monitor
