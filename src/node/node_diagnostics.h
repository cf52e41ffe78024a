// The monitor's health on /diagnostics.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/fallback_detector.h"
#include "monitor/cycle_report.h"
#include "monitor/diagnostics/motion_watch.h"
#include "monitor/diagnostics/timing_watch.h"
#include "monitor/diagnostics/trade_watch.h"
#include "monitor/diagnostics/transform_watch.h"
#include "monitor/input/mesh_mailbox.h"
#include "monitor/rules/parameters.h"
#include "monitor/rules/rules_in_force.h"
#include "node/robot_source.h"

namespace deformable_contact_monitor {

// Kinds of status: status, mesh:<object>, tf, timing, output, allowed; in swept motion, motion;
// with a tolerance or a budget, trade. Threads may call every function at any time.
class NodeDiagnostics {
 public:
  // All arguments but the handles must outlive this.
  NodeDiagnostics(const MonitorParameters& parameters, const MeshMailboxes& mailboxes,
                  const RobotSource& robot, const ros::NodeHandle& node,
                  const ros::NodeHandle& private_node);

  // A cycle begins.
  void recordStart();
  // A cycle ended.
  void recordCycle(const CycleReport& report, const ContactArray& sent, const CycleTimes& times);
  // Of such a cycle: `answer_s` from the arrival of that mesh until its states were out.
  void recordTrade(const CycleReport& report, double answer_s);
  // The last mesh of this object was looked at: what is counted since the start.
  void recordMesh(std::size_t object, const MeshCounters& counters);
  // What is odd about the size or place of this object; empty: nothing.
  void recordOddity(const std::string& object, const std::string& oddity);
  void recordTransforms(const TransformReport& report);
  // A detection that failed; empty: it did not.
  void recordDetectorError(const std::string& error);
  // The backend that was asked for fails, or works again.
  void recordBackend(const BackendState& state);
  void recordReset(const std::string& reason);
  // Bodies that are not closed, by name; empty: all are that were looked at.
  void recordOpenBodies(const std::string& bodies);
  void recordEnabled(bool enabled);
  void recordRules(const RulesInForce& rules);

  // Why no cycle has ended lately: for states that have become too old.
  std::string whySilent() const;

  // The ROS master does not know this node any more.
  void recordForgotten() { is_forgotten_ = true; }

  // Why the object's newest mesh was refused, and what is odd about the newest that was not; empty:
  // nothing.
  std::pair<std::string, std::string> meshProblems(std::size_t object) const;
  bool isEnabled() const;

  // To be called once a second.
  void publish() { updater_.force_update(); }

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;
  using Clock = std::chrono::steady_clock;

  void describeStatus(Status& status);
  void describeMesh(std::size_t object, Status& status);
  void describeTransforms(Status& status);
  void describeTiming(Status& status);
  void describeOutput(Status& status);
  void describeAllowed(Status& status);
  void describeMotion(Status& status);
  void describeTrade(Status& status);

  struct MeshWatch {
    MeshCounters counters;
    std::string oddity;
    std::uint64_t received = 0;  // at the last publication
    Clock::time_point when = Clock::now();
  };

  const MonitorParameters& parameters_;
  const MeshMailboxes& mailboxes_;
  const RobotSource& robot_;
  diagnostic_updater::Updater updater_;

  std::atomic<bool> is_forgotten_{false};

  mutable std::mutex mutex_;        // guards what follows
  std::vector<MeshWatch> watches_;  // by object
  bool enabled_ = true;
  std::string backend_, detector_error_, last_reset_, open_bodies_;
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
