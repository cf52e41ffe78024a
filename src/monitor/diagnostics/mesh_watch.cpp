// Watches whether an object's meshes come, and whether each of them has a cycle.
#include "monitor/diagnostics/mesh_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <algorithm>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {

using diagnostic_msgs::DiagnosticStatus;

MeshWatch::MeshWatch(bool required, double max_age_s, double min_rate_hz, SteadyTime now)
    : required_(required), max_age_s_(max_age_s), min_rate_hz_(min_rate_hz), when_(now) {}

// A simulator may need several seconds for one of its own, so shorter times would tell nothing.
void MeshWatch::measure(const MeshSituation& situation, SteadyTime now) {
  constexpr double kLeastS = 0.9, kMostS = 5, kTolerated = 0.02, kKept = 0.9;
  const double real_s = toSeconds(now - when_);
  const double ros_s = secondsBetween(situation.ros_time, ros_when_);
  const bool is_begun = !situation.is_simulated || !ros_when_.isZero();
  const bool is_short = situation.is_simulated && ros_s >= 0 && ros_s < kLeastS && real_s < kMostS;
  if (real_s <= 0 || (is_begun && is_short)) return;
  const MeshCounters& meshes = situation.meshes;
  const auto came = static_cast<double>(meshes.received - received_);
  const auto dropped = static_cast<double>(meshes.dropped - dropped_);
  received_ = meshes.received;
  dropped_ = meshes.dropped;
  when_ = now;
  ros_when_ = situation.ros_time;
  if (!is_begun) return;
  is_measured_ = true;
  const double length_s = situation.is_simulated && ros_s > 0 ? ros_s : real_s;
  rate_hz_ = came / length_s;
  const double most = situation.max_rate_hz > 0 ? situation.max_rate_hz * real_s : came;
  period_s_ = came > 0 ? real_s / std::min(came, most) : 0;
  const bool too_many = came > most ? came - dropped < kKept * most : dropped > kTolerated * came;
  drops_.clear();
  if (!too_many || !situation.is_enabled) return;
  drops_ = std::to_string(static_cast<std::uint64_t>(dropped)) + " of " +
           std::to_string(static_cast<std::uint64_t>(came)) +
           " meshes had no cycle: they come faster than cycles end, or out of order";
}

void MeshWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status,
                         const MeshSituation& situation, SteadyTime now) {
  measure(situation, now);
  const MeshCounters& meshes = situation.meshes;
  const auto bad = required_ ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN;
  if (meshes.received == 0) {
    status.summary(bad, "no mesh received yet");
  } else if (!meshes.problem.empty()) {
    status.summary(bad, "mesh refused: " + meshes.problem);
  } else if (is_measured_ && rate_hz_ == 0) {
    status.summary(bad, "no mesh within the last second");
  } else if (is_measured_ && rate_hz_ * max_age_s_ < 1) {
    status.summary(DiagnosticStatus::WARN,
                   "slower than max_mesh_age_s, so UNKNOWN between meshes; raise max_mesh_age_s");
  } else if (is_measured_ && rate_hz_ < min_rate_hz_) {
    status.summary(DiagnosticStatus::WARN, "rate below diagnostic_min_rate_hz");
  } else {
    status.summary(DiagnosticStatus::OK, meshes.stamped_on_receipt > 0
                                             ? "meshes arrive, stamped on receipt"
                                             : "meshes arrive");
  }
  for (const std::string& warning : {drops_, situation.rivals, anomaly_}) {
    if (!warning.empty()) status.mergeSummary(DiagnosticStatus::WARN, warning);
  }
  status.add("rate [Hz]", rate_hz_);
  if (!meshes.newest.isZero()) {
    status.add("age of newest [s]", secondsBetween(situation.ros_time, meshes.newest));
  }
  status.add("received", meshes.received);
  status.add("stamped on receipt", meshes.stamped_on_receipt);
  status.add("dropped", meshes.dropped);
  status.add("refused", meshes.rejected);
  status.add("topology changes", meshes.topology_changes);
}

}  // namespace deformable_contact_monitor
