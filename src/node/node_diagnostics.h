// Publishes the monitor's health on /diagnostics.
//
// The watches of monitor/diagnostics follow the health; this class guards them with a mutex, adds
// what only the node knows (inputs, robot, rules, backend), and publishes once a second.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/backend_choice.h"
#include "core/steady_time.h"
#include "monitor/cycle_report.h"
#include "monitor/diagnostics/mesh_watch.h"
#include "monitor/diagnostics/watches.h"
#include "monitor/input/mesh_input.h"
#include "monitor/rules/parameters.h"
#include "monitor/rules/rule_texts.h"
#include "node/robot_source.h"

namespace deformable_contact_monitor {

// Publishes the statuses `status`, `mesh:<object>`, `tf`, `timing`, `output` and `allowed`; in
// swept motion also `motion`, with a tolerance or a budget also `trade`. The record functions note
// what happens; publish() turns it into messages. Every function may be called by any thread.
class NodeDiagnostics {
 public:
  // All arguments but the handles must outlive this.
  NodeDiagnostics(const MonitorParameters& parameters, const MeshInputs& meshes,
                  const RobotSource& robot, const ros::NodeHandle& node,
                  const ros::NodeHandle& private_node);

  // Notes that a cycle begins.
  void recordStart();
  // Notes that a cycle ended, and what was published from it.
  void recordCycle(const CycleReport& report, const ContactArray& sent, const CycleTimes& times);
  // Notes how long [s] it took from the arrival of the cycle's mesh until the states were out. Does
  // nothing without a tolerance and a budget.
  void recordTrade(const CycleReport& report, double answer_s);
  // Takes what is anomalous about the size or place of an object, as one line of text; an empty
  // text ends the anomaly.
  void recordAnomaly(const std::string& object, const std::string& anomaly);
  // Notes which transforms the last cycle looked up, and which of them were missing.
  void recordTransforms(const TransformReport& report);
  // Takes why a detection failed; empty: it did not.
  void recordDetectorError(const std::string& error) { set(error, &detector_error_); }
  // Takes the backend's state when it fails, or works again.
  void recordBackend(const BackendState& state) { set(state, &backend_state_); }
  // Notes that meshes, transforms and states were discarded, and why. Counts the resets.
  void recordReset(const std::string& reason);
  // Takes the names of bodies that are not closed; empty: all examined bodies are closed.
  void recordOpenBodies(const std::string& bodies) { set(bodies, &open_bodies_); }
  // Takes the highest rate of an object's cycles [Hz]; 0: no limit.
  void recordMaxRate(double max_rate_hz) { set(max_rate_hz, &max_rate_hz_); }
  // Notes whether the monitor is enabled, and which rules are in force.
  void recordEnabled(bool enabled) { set(enabled, &enabled_); }
  void recordRules(const RulesInForce& rules) { set(rules, &rules_); }
  // Notes that the ROS master no longer knows this node.
  void recordUnregistered() { is_unregistered_ = true; }

  // Returns why no cycle has ended lately, for states that have become too old.
  std::string whySilent() const;

  // Returns why the object's newest mesh was rejected, and what is anomalous about the newest mesh
  // that was not; empty: nothing.
  std::pair<std::string, std::string> meshProblems(std::size_t object) const;
  // Returns false after ~set_enabled has switched the monitor off.
  bool isEnabled() const;

  // Publishes all statuses. Call it once a second.
  void publish() { updater_.force_update(); }

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;
  using Clock = std::chrono::steady_clock;

  template <class Value>
  void set(const Value& value, Value* to) {
    const std::lock_guard<std::mutex> lock(mutex_);
    *to = value;
  }
  // Adds a status that `describe` fills while the mutex is held.
  void add(const std::string& name, const std::function<void(Status&)>& describe);
  // Each of these functions fills the status of the same name. The caller holds the mutex.
  void describeStatus(Status& status) const;
  void describeMesh(std::size_t object, Status& status);
  void describeTiming(Status& status);
  void describeOutput(Status& status) const;
  void describeAllowed(Status& status) const;

  const MonitorParameters& parameters_;
  const MeshInputs& meshes_;
  const RobotSource& robot_;
  diagnostic_updater::Updater updater_;

  std::atomic<bool> is_unregistered_{false};

  mutable std::mutex mutex_;        // guards the members below
  std::vector<MeshWatch> watches_;  // by object
  bool enabled_ = true;
  double max_rate_hz_;
  std::string backend_, device_memory_mib_, detector_error_, last_reset_, open_bodies_;
  BackendState backend_state_;
  std::uint64_t cycles_ = 0, resets_ = 0;
  TimingWatch timing_{Clock::now()};
  TransformWatch transforms_;
  MotionWatch motion_;
  TradeWatch trade_;
  RulesInForce rules_;
  ContactArray output_;  // of the latest cycle, without the pairs
};

}  // namespace deformable_contact_monitor
