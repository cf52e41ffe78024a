// How long cycles take, and whether they keep up.
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "core/steady_time.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// What a cycle took [s].
struct CycleTimes {
  double work_s = 0;  // from taking transforms to the markers
  // From the arrival of the mesh that asked for it until its states were out, and until all but the
  // markers was.
  double states_s = 0, latency_s = 0;
};

// One thread at a time. Reads no clock.
class TimingWatch {
 public:
  explicit TimingWatch(SteadyTime now) : described_(now) {}

  // A cycle begins.
  void start(SteadyTime now) { running_since_ = now; }

  // It has ended.
  void end(const CycleReport& report, const CycleTimes& times);

  // Of the cycle that has not ended [s]; 0 if there is none.
  double runsFor(SteadyTime now) const;

  // A warning if cycles took more than nine tenths of the time since the last description, or one
  // has been running for more than half a second; then mean, median, p95 and most of the last 200
  // cycles' latency, that of their states, with and without the detection, work, detection and
  // stages; in swept motion of the steps, too, and of the latency without them, which is what
  // instant motion has.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status, SteadyTime now);

 private:
  std::map<std::string, std::deque<double>> times_ms_;  // by what; the latest cycles
  std::uint64_t cold_starts_ = 0;
  double busy_s_ = 0;  // since described_
  SteadyTime described_;
  std::optional<SteadyTime> running_since_;
};

}  // namespace deformable_contact_monitor
