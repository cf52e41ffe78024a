// The monitor's health on /diagnostics.
#include "node/node_diagnostics.h"

#include "core/steady_time.h"
#include "monitor/diagnostics/backend_status.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {

using diagnostic_msgs::DiagnosticStatus;

NodeDiagnostics::NodeDiagnostics(const MonitorParameters& parameters,
                                 const MeshMailboxes& mailboxes, const RobotSource& robot,
                                 const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : parameters_(parameters),
      mailboxes_(mailboxes),
      robot_(robot),
      updater_(node, private_node, private_node.getNamespace()),
      watches_(mailboxes.size()),
      trade_(parameters.detector.tolerance_m, parameters.budget_ms / 1e3) {
  updater_.setHardwareID("none");
  updater_.add("status", this, &NodeDiagnostics::describeStatus);
  for (std::size_t i = 0; i < mailboxes_.size(); ++i) {
    updater_.add("mesh:" + parameters_.objects[i].name,
                 [this, i](Status& status) { describeMesh(i, status); });
  }
  updater_.add("tf", this, &NodeDiagnostics::describeTransforms);
  updater_.add("timing", this, &NodeDiagnostics::describeTiming);
  updater_.add("output", this, &NodeDiagnostics::describeOutput);
  updater_.add("allowed", this, &NodeDiagnostics::describeAllowed);
  if (parameters_.motion == Motion::kSwept) {
    updater_.add("motion", this, &NodeDiagnostics::describeMotion);
  }
  if (tradesAccuracy(parameters_)) updater_.add("trade", this, &NodeDiagnostics::describeTrade);
}

void NodeDiagnostics::recordStart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  timing_.start(Clock::now());
}

std::string NodeDiagnostics::whySilent() const {
  constexpr double kLongS = 0.1;
  const std::lock_guard<std::mutex> lock(mutex_);
  const double running_s = timing_.runsFor(Clock::now());
  if (running_s < kLongS) return "no new mesh within max_mesh_age_s";
  return "busy: a cycle has been running for " + std::to_string(running_s) + " s";
}

void NodeDiagnostics::recordCycle(const CycleReport& report, const ContactArray& sent,
                                  const CycleTimes& times) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++cycles_;
  timing_.end(report, times);
  motion_.record(report);
  backend_ = report.backend;
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

void NodeDiagnostics::recordMesh(std::size_t object, const MeshCounters& counters) {
  const std::lock_guard<std::mutex> lock(mutex_);
  watches_[object].counters = counters;
}

void NodeDiagnostics::recordOddity(const std::string& object, const std::string& oddity) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    if (parameters_.objects[i].name == object) watches_[i].oddity = oddity;
  }
}

std::pair<std::string, std::string> NodeDiagnostics::meshProblems(std::size_t object) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {watches_[object].counters.refusal, watches_[object].oddity};
}

bool NodeDiagnostics::isEnabled() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return enabled_;
}

void NodeDiagnostics::recordTransforms(const TransformReport& report) {
  const std::lock_guard<std::mutex> lock(mutex_);
  transforms_.record(report, Clock::now());
}

void NodeDiagnostics::recordDetectorError(const std::string& error) {
  const std::lock_guard<std::mutex> lock(mutex_);
  detector_error_ = error;
}

void NodeDiagnostics::recordBackend(const BackendState& state) {
  const std::lock_guard<std::mutex> lock(mutex_);
  backend_state_ = state;
}

void NodeDiagnostics::recordReset(const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++resets_;
  last_reset_ = reason;
}

void NodeDiagnostics::recordOpenBodies(const std::string& bodies) {
  const std::lock_guard<std::mutex> lock(mutex_);
  open_bodies_ = bodies;
}

void NodeDiagnostics::recordEnabled(bool enabled) {
  const std::lock_guard<std::mutex> lock(mutex_);
  enabled_ = enabled;
}

void NodeDiagnostics::recordRules(const RulesInForce& rules) {
  const std::lock_guard<std::mutex> lock(mutex_);
  rules_ = rules;
}

void NodeDiagnostics::describeStatus(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  status.summary(DiagnosticStatus::OK, "monitoring");
  if (!enabled_) status.summary(DiagnosticStatus::WARN, "disabled by ~set_enabled");
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
    if (!robot) status.mergeSummary(DiagnosticStatus::ERROR, "no robot received yet");
    if (!unusable.empty()) {
      status.mergeSummary(DiagnosticStatus::WARN, "links without usable geometry: " + unusable);
    }
    if (!robot_.problem().empty()) {
      status.mergeSummary(DiagnosticStatus::ERROR, "robot refused: " + robot_.problem());
    }
  }
  if (!detector_error_.empty()) {
    status.mergeSummary(DiagnosticStatus::ERROR, "detection failed: " + detector_error_);
  }
  const BackendStatus backend = backendStatus(parameters_.backend, backend_state_);
  if (backend.level != DiagnosticStatus::OK) status.mergeSummary(backend.level, backend.summary);
  if (is_forgotten_) {
    status.mergeSummary(DiagnosticStatus::ERROR,
                        "the ROS master does not know this node any more: start it again");
  }
  status.add("backend", backend_);
  status.add("backend asked for", toString(parameters_.backend));
  status.add("backend problem", backend_state_.problem);
  status.add("cycles", cycles_);
  status.add("resets", resets_);
  status.add("last reset", last_reset_);
  if (parameters_.containment) status.add("not closed", open_bodies_);
}

void NodeDiagnostics::describeMesh(std::size_t object, Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  MeshWatch& watch = watches_[object];
  const MeshCounters& counters = watch.counters;
  const ArrivalCounters arrived = mailboxes_[object].counters();
  const double rate_hz =
      static_cast<double>(arrived.received - watch.received) / secondsSince(watch.when);
  watch.received = arrived.received;
  watch.when = Clock::now();

  const auto bad =
      parameters_.objects[object].required ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN;
  if (arrived.received == 0) {
    status.summary(bad, "no mesh received yet");
  } else if (!counters.refusal.empty()) {
    status.summary(bad, "mesh refused: " + counters.refusal);
  } else if (rate_hz == 0) {
    status.summary(bad, "no mesh within the last second");
  } else if (rate_hz * parameters_.max_mesh_age_s < 1) {
    status.summary(DiagnosticStatus::WARN,
                   "slower than max_mesh_age_s: UNKNOWN between its meshes; raise max_mesh_age_s");
  } else if (rate_hz < parameters_.diagnostic_min_rate_hz) {
    status.summary(DiagnosticStatus::WARN, "rate below diagnostic_min_rate_hz");
  } else {
    status.summary(DiagnosticStatus::OK, arrived.stamped_on_receipt > 0
                                             ? "meshes arrive, stamped on receipt"
                                             : "meshes arrive");
  }
  if (!watch.oddity.empty()) status.mergeSummary(DiagnosticStatus::WARN, watch.oddity);
  status.add("rate [Hz]", rate_hz);
  if (!counters.stamp.isZero()) {
    status.add("age of newest [s]", secondsBetween(ros::Time::now(), counters.stamp));
  }
  status.add("received", arrived.received);
  status.add("stamped on receipt", arrived.stamped_on_receipt);
  status.add("dropped", arrived.dropped + counters.dropped);
  status.add("refused", counters.refused);
  status.add("topology changes", counters.topology_changes);
}

void NodeDiagnostics::describeTransforms(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  transforms_.describe(status, Clock::now());
}

void NodeDiagnostics::describeTiming(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  timing_.describe(status, Clock::now());
}

void NodeDiagnostics::describeMotion(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  motion_.describe(status);
}

void NodeDiagnostics::describeTrade(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  trade_.describe(status);
}

void NodeDiagnostics::describeOutput(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (cycles_ == 0) {
    status.summary(DiagnosticStatus::WARN, "nothing published yet");
    return;
  }
  // A tolerance was asked for, and that it leaves pairs of triangles out is no fault.
  const bool is_whole = output_.guaranteed && output_.skipped.empty() && !output_.truncated &&
                        !output_.timed_out && output_.rejected_triangles == 0;
  status.summary(DiagnosticStatus::OK, output_.complete ? "complete" : "within tolerance_m");
  if (!output_.complete && !is_whole) status.summary(DiagnosticStatus::WARN, "not complete");
  for (const std::string& skipped : output_.skipped) status.add("skipped", skipped);
  status.add("pairs", output_.pair_count);
  status.add("truncated", output_.truncated);
  status.add("undecided", output_.undecided);
  status.add("rejected triangles", output_.rejected_triangles);
  status.add("age [s]", output_.age.toSec());
}

void NodeDiagnostics::describeAllowed(Status& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
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
  for (const auto& [body, rules] : rules_.bodies) status.add(body, rules);
}

}  // namespace deformable_contact_monitor
