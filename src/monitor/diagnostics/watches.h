// Watches the monitor's health from cycle to cycle and describes it for /diagnostics.
//
// Each watch is one status: record() takes what a cycle found, describe() fills the status once a
// second. Watches read no clock and are not safe for use by several threads; NodeDiagnostics gives
// them the time and guards them.
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "core/backend_choice.h"
#include "core/steady_time.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// The times of a cycle [s].
struct CycleTimes {
  double work_s = 0;     // from taking transforms to publishing markers
  double states_s = 0;   // from the arrival of the triggering mesh to its published states
  double latency_s = 0;  // from that arrival until everything but the markers was published
};

// The status `timing`: how long cycles take, and whether they keep up with the meshes.
class TimingWatch {
 public:
  explicit TimingWatch(SteadyTime now) : described_(now) {}

  // Notes that a cycle begins.
  void start(SteadyTime now) { running_since_ = now; }

  // Notes that it has ended.
  void end(const CycleReport& report, const CycleTimes& times);

  // Returns for how long [s] a cycle has been running; 0 if none is.
  double runsFor(SteadyTime now) const;

  // Warns if cycles took more than half of the time since the last call, if the 95th percentile of
  // their times exceeds `period_s` [s], the least time between two meshes (0: unknown), or if one
  // has been running for more than half a second. Adds mean, median, p95 and maximum over the last
  // 200 cycles of: latency, latency of states with and without detection, work, detection, and each
  // stage (transform, cluster, assign, sort, sweep, oversized, narrow_phase, output). In swept
  // motion, adds the time of the steps and the latency without them, which instant motion has.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status, SteadyTime now,
                double period_s = 0);

 private:
  std::map<std::string, std::deque<double>> times_ms_;  // by what was timed; latest cycles
  std::uint64_t cold_starts_ = 0;
  double busy_s_ = 0;  // since described_
  SteadyTime described_;
  std::optional<SteadyTime> running_since_;
};

// The status `motion`, in swept motion: how many steps (time intervals between two cycles) were
// examined, what they found, and which are missing.
class MotionWatch {
 public:
  void record(const CycleReport& report);

  // Warns if a step since the last call failed or was cut off. A step that is missing because there
  // was nothing to start from is only counted.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  void recordStep(const CycleReport& report, const SweepReport& sweep);

  std::uint64_t steps_ = 0, missing_ = 0, passed_ = 0;  // since the start
  std::string why_missing_;                             // of the latest one
  std::string problem_;                                 // since the last description
  std::uint64_t pairs_ = 0;                             // of the last step, as the following ones
  int sub_steps_ = 0;
  float pad_m_ = 0;
};

// The status `trade`, with a tolerance or a budget: what they cost. Shows how many pairs of bodies
// were decided, and when the states were published.
class TradeWatch {
 public:
  // Takes the parameters tolerance_m and budget_ms [s]; 0 means that it is not set.
  TradeWatch(double tolerance_m, double budget_s)
      : tolerance_m_(tolerance_m), budget_s_(budget_s) {}

  // Takes a cycle. `answer_s` is the time [s] from the arrival of its mesh to its states.
  void record(const CycleReport& report, double answer_s);

  // Describes the latest 200 cycles. Warns if the 99th percentile of their times exceeds the budget
  // by more than a tenth.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  struct Cycle {
    std::uint64_t pairs, decided;
    double answer_s;
  };

  double tolerance_m_, budget_s_;
  std::deque<Cycle> cycles_;  // the latest ones
};

// The status `tf`: which bodies have no transform, and since when.
class TransformWatch {
 public:
  // Takes which transforms a cycle asked for and did not get. Other bodies keep their state.
  void record(const TransformReport& report, SteadyTime now);

  // Warns with the names of the bodies without a transform; an error once one of them has had none
  // for more than 5 s. Adds the longest wait since the last call. Bodies that no cycle has asked
  // for during 30 s are forgotten, because nothing is known of them any more.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status, SteadyTime now);

 private:
  struct Missing {
    SteadyTime since, last_asked;
    std::string problem;
  };

  std::map<std::string, Missing> missing_;  // by body
  std::uint64_t misses_ = 0;
  double worst_wait_s_ = 0;
};

// The line about the backend in the diagnostics and on the console.
struct BackendStatus {
  unsigned char level = 0;  // of diagnostic_msgs/DiagnosticStatus
  std::string summary;      // one line: why CUDA is not used, and what helps; empty: all is well
};

// Returns ERROR if only a restart helps, and for any fault of CUDA if it was asked for by name.
// Returns WARN if CUDA is tried again without help, if the scene is too large for CUDA (then no
// device is at fault), or if one of several devices failed. Returns OK with a summary if `auto`
// finds no CUDA at all.
BackendStatus backendStatus(BackendChoice asked, const BackendState& state);

}  // namespace deformable_contact_monitor
