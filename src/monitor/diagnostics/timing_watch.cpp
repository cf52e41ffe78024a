// How long cycles take, and whether they keep up.
#include "monitor/diagnostics/timing_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <vector>

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr std::size_t kTimedCycles = 200;
constexpr double kBusyShare = 0.9;
constexpr double kLongCycleS = 0.5;

std::string describeTimes(const std::deque<double>& times_ms) {
  std::vector<double> sorted(times_ms.begin(), times_ms.end());
  std::sort(sorted.begin(), sorted.end());
  const double mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / sorted.size();
  char text[128];
  std::snprintf(text, sizeof text, "mean %.3f, median %.3f, p95 %.3f, max %.3f", mean,
                sorted[(sorted.size() - 1) / 2], sorted[(sorted.size() - 1) * 95 / 100],
                sorted.back());
  return text;
}

}  // namespace

void TimingWatch::end(const CycleReport& report, const CycleTimes& cycle) {
  const DetectionResult* const result = report.result;
  running_since_.reset();
  busy_s_ += cycle.work_s;
  if (result == nullptr) return;
  if (result->started_cold) ++cold_starts_;
  const auto add = [this](const std::string& what, double ms) {
    std::deque<double>& times = times_ms_[what];
    times.push_back(ms);
    if (times.size() > kTimedCycles) times.pop_front();
  };
  add("latency [ms]", 1e3 * cycle.latency_s);
  add("latency of states [ms]", 1e3 * cycle.states_s);
  add("cycle [ms]", 1e3 * cycle.work_s);
  add("detection [ms]", result->round_trip_ms);
  add("latency of states without detection [ms]", 1e3 * cycle.states_s - result->round_trip_ms);
  for (const auto& [stage, ms] : result->stages_ms) add("stage " + stage + " [ms]", ms);
  if (report.motion == Motion::kInstant) return;
  double steps_s = 0;
  for (const SweepReport& sweep : report.sweeps) steps_s += sweep.compute_s;
  add("steps [ms]", 1e3 * steps_s);
  add("latency without steps [ms]", 1e3 * (cycle.latency_s - steps_s));
}

double TimingWatch::runsFor(SteadyTime now) const {
  return running_since_ ? toSeconds(now - *running_since_) : 0;
}

void TimingWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status, SteadyTime now) {
  const double busy = busy_s_ / toSeconds(now - described_);
  busy_s_ = 0;
  described_ = now;
  status.summary(DiagnosticStatus::OK, "in time");
  if (busy > kBusyShare) {
    status.summary(DiagnosticStatus::WARN, "always busy: meshes come faster than they are done");
  }
  if (runsFor(now) > kLongCycleS) {
    status.summary(DiagnosticStatus::WARN,
                   "busy: a cycle runs for " + std::to_string(runsFor(now)) + " s");
  }
  status.add("busy share", busy);
  status.add("cold starts", cold_starts_);
  for (const auto& [what, times_ms] : times_ms_) status.add(what, describeTimes(times_ms));
}

}  // namespace deformable_contact_monitor
