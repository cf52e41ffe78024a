// Watches the monitor's health from cycle to cycle and describes it for /diagnostics.
//
// A watch keeps numbers of the latest cycles, or since the last description, so that a problem that
// is over does not stay on the screen.
#include "monitor/diagnostics/watches.h"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "monitor/state/pair_state.h"

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr std::size_t kLatestCycles = 200;  // that times and shares are computed from

// Returns the nearest-rank percentile of the values; 0 if there are none.
double percentile(const std::deque<double>& values, std::size_t percent) {
  if (values.empty()) return 0;
  std::vector<double> sorted(values.begin(), values.end());
  const std::size_t rank = (sorted.size() - 1) * percent / 100;
  const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(sorted.begin(), place, sorted.end());
  return *place;
}

// Returns "mean 1.000, median 1.000, p95 1.000, max 1.000". `times_ms` must not be empty.
std::string describeTimes(const std::deque<double>& times_ms) {
  const double mean = std::accumulate(times_ms.begin(), times_ms.end(), 0.0) / times_ms.size();
  char text[128];
  std::snprintf(text, sizeof text, "mean %.3f, median %.3f, p95 %.3f, max %.3f", mean,
                percentile(times_ms, 50), percentile(times_ms, 95), percentile(times_ms, 100));
  return text;
}

// Returns the first body without a step, and why; empty if every body has one.
std::string firstSkipped(const CycleReport& report, const SweepReport& sweep) {
  for (BodyId id = 0; id < sweep.bodies.size(); ++id) {
    const std::string& why = sweep.bodies[id].skipped;
    if (!why.empty()) return report.bodies[id].name + ": " + why;
  }
  return "";
}

// A fault that `auto` copes with by itself is a warning. Whoever asks for CUDA by name relies on
// it.
unsigned char levelOf(BackendChoice asked, BackendFault fault) {
  const bool by_name = asked == BackendChoice::kCuda;
  switch (fault) {
    case BackendFault::kSticky:
      return DiagnosticStatus::ERROR;
    case BackendFault::kSceneTooLarge:
      return DiagnosticStatus::WARN;
    case BackendFault::kUnavailable:
      return by_name ? DiagnosticStatus::ERROR : DiagnosticStatus::OK;
    default:
      return by_name ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN;
  }
}

// Returns what helps against the fault, to be appended to the reason; empty if nothing is known.
std::string adviceOf(const BackendState& state) {
  if (state.fault == BackendFault::kSticky) return "; restart this process to use CUDA again";
  if (state.fault == BackendFault::kSceneTooLarge) return "; smaller scenes run on CUDA";
  return state.tried_again ? "; CUDA is tried again at least once a minute" : "";
}

}  // namespace

void TimingWatch::end(const CycleReport& report, const CycleTimes& cycle) {
  const DetectionResult* const result = report.result.get();
  running_since_.reset();
  busy_s_ += cycle.work_s;
  if (result == nullptr) return;
  if (result->started_cold) ++cold_starts_;
  const auto add = [this](const std::string& what, double ms) {
    std::deque<double>& times = times_ms_[what];
    times.push_back(ms);
    if (times.size() > kLatestCycles) times.pop_front();
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

// A cycle that runs for long outweighs a busy loop, so it is set last. A few cycles tell nothing:
// the first ones take longer.
void TimingWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status, SteadyTime now,
                           double period_s) {
  constexpr double kBusy = 0.5, kAlwaysBusy = 0.9, kLongCycleS = 0.5;
  constexpr std::size_t kFewCycles = 20;
  const double busy = busy_s_ / toSeconds(now - described_);
  busy_s_ = 0;
  described_ = now;
  status.summary(DiagnosticStatus::OK, "in time");
  if (busy > kAlwaysBusy) {
    status.summary(DiagnosticStatus::WARN,
                   "always busy: meshes arrive faster than cycles process them");
  } else if (busy > kBusy) {
    status.summaryf(DiagnosticStatus::WARN,
                    "busy for %.0f %% of the time: little is left until meshes are dropped",
                    100 * busy);
  }
  const std::deque<double>& cycles_ms = times_ms_["cycle [ms]"];
  const double p95_ms = cycles_ms.size() < kFewCycles ? 0 : percentile(cycles_ms, 95);
  if (period_s > 0 && p95_ms > 1e3 * period_s) {
    char text[128];
    std::snprintf(text, sizeof text, "cycles take %.1f ms (p95), but a mesh comes every %.1f ms",
                  p95_ms, 1e3 * period_s);
    status.mergeSummary(DiagnosticStatus::WARN, text);
  }
  if (runsFor(now) > kLongCycleS) {
    status.summary(DiagnosticStatus::WARN,
                   "busy: a cycle has been running for " + std::to_string(runsFor(now)) + " s");
  }
  status.add("busy share", busy);
  status.add("cold starts", cold_starts_);
  for (const auto& [what, times_ms] : times_ms_) {
    if (!times_ms.empty()) status.add(what, describeTimes(times_ms));
  }
}

void MotionWatch::record(const CycleReport& report) {
  for (const SweepReport& sweep : report.sweeps) recordStep(report, sweep);
}

// Counts a pair of bodies as passed if it touched during the step and does not touch at its end.
void MotionWatch::recordStep(const CycleReport& report, const SweepReport& sweep) {
  const std::string skipped = firstSkipped(report, sweep);
  if (sweep.result == nullptr || !skipped.empty()) {
    ++missing_;
    why_missing_ = skipped.empty() ? sweep.problem : skipped;
  }
  if (sweep.from.isZero()) return;
  if (sweep.result == nullptr) {
    problem_ = "the detection of a step failed";
    return;
  }
  ++steps_;
  const DetectionResult& result = sweep.result->detection;
  if (result.cut_off) problem_ = "a step was cut off: " + result.cut_off_because;
  pairs_ = result.contacts.size() + result.left_out;
  sub_steps_ = sweep.result->sub_steps;
  pad_m_ = sweep.result->pad_m;
  if (report.result == nullptr) return;
  const auto touching = report.result->touchingBodies(), touched = result.touchingBodies();
  passed_ += static_cast<std::uint64_t>(std::count_if(
      touched.begin(), touched.end(), [&](const auto& pair) { return touching.count(pair) == 0; }));
}

void MotionWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::string problem = std::exchange(problem_, "");
  status.summary(problem.empty() ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                 problem.empty() ? "swept" : problem);
  status.add("steps", steps_);
  status.add("steps missing or not of all bodies", missing_);
  status.add("why the last of them", why_missing_);
  status.add("pairs of bodies passed", passed_);
  status.add("triangle pairs in the last step", pairs_);
  status.add("sub-steps of the last step", sub_steps_);
  status.add("pad of the last step [m]", pad_m_);
}

// Without bounds on the distance, a pair is decided unless the detection was cut off before it
// found a contact of the pair.
void TradeWatch::record(const CycleReport& report, double answer_s) {
  if (report.result == nullptr) return;
  Cycle cycle{0, 0, answer_s};
  const auto touching = report.result->touchingBodies();
  for (const auto& [a, b] : report.scene->enabledPairs()) {
    const std::optional<PairBounds> distance =
        boundsOf(report, {a, b, false}, static_cast<float>(tolerance_m_));
    const bool is_decided = distance ? distance->decision != PairDecision::kOpen
                                     : !report.result->cut_off || touching.count({a, b}) > 0;
    ++cycle.pairs;
    cycle.decided += is_decided ? 1 : 0;
  }
  cycles_.push_back(cycle);
  if (cycles_.size() > kLatestCycles) cycles_.pop_front();
}

void TradeWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  constexpr double kLate = 1.1;
  std::uint64_t pairs = 0, decided = 0;
  std::deque<double> answers_ms;
  for (const Cycle& cycle : cycles_) {
    pairs += cycle.pairs;
    decided += cycle.decided;
    answers_ms.push_back(1e3 * cycle.answer_s);
  }
  const double p99_ms = percentile(answers_ms, 99);
  const bool is_late = budget_s_ > 0 && p99_ms > kLate * 1e3 * budget_s_;
  status.summary(is_late ? DiagnosticStatus::WARN : DiagnosticStatus::OK,
                 is_late ? "states come later than budget_ms" : "in force");
  status.add("tolerance [m]", tolerance_m_);
  status.add("budget [ms]", 1e3 * budget_s_);
  status.addf(
      "pairs of bodies decided", "%.2f %%",
      pairs == 0 ? 100.0 : 100.0 * static_cast<double>(decided) / static_cast<double>(pairs));
  status.addf("arrival to states [ms]", "median %.3f, p99 %.3f, max %.3f",
              percentile(answers_ms, 50), p99_ms, percentile(answers_ms, 100));
  if (budget_s_ > 0) status.addf("p99 over budget", "%.2f", p99_ms / (1e3 * budget_s_));
}

// A body that was missing before keeps the time since when. Bodies that are asked for and found are
// dropped from the list.
void TransformWatch::record(const TransformReport& report, SteadyTime now) {
  worst_wait_s_ = std::max(worst_wait_s_, report.waited_s);
  misses_ += report.misses.size();
  std::map<std::string, Missing> before;
  for (const std::string& body : report.asked) {
    if (auto entry = missing_.extract(body)) before.insert(std::move(entry));
  }
  for (const TransformReport::Miss& miss : report.misses) {
    const auto found = before.find(miss.body);
    const SteadyTime since = found == before.end() ? now : found->second.since;
    missing_[miss.body] = {since, now, miss.answer.problem};
  }
}

// Forgets bodies that nobody asks for, then lists those that are missing with their reasons.
void TransformWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status, SteadyTime now) {
  constexpr double kMissingTooLongS = 5, kForgottenAfterS = 30;
  status.summary(DiagnosticStatus::OK, "all transforms in time");
  std::string missing;
  double longest_s = 0;
  for (auto entry = missing_.begin(); entry != missing_.end();) {
    const bool forgotten = toSeconds(now - entry->second.last_asked) > kForgottenAfterS;
    entry = forgotten ? missing_.erase(entry) : std::next(entry);
  }
  for (const auto& [body, how] : missing_) {
    const double since_s = toSeconds(now - how.since);
    longest_s = std::max(longest_s, since_s);
    missing += (missing.empty() ? "" : ", ") + body;
    status.add(body + " missing for [s]", since_s);
    status.add(body, how.problem);
  }
  if (!missing.empty()) {
    status.summary(longest_s > kMissingTooLongS ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN,
                   "no transform for: " + missing);
  }
  status.add("misses", misses_);
  status.add("worst wait [s]", worst_wait_s_);
  worst_wait_s_ = 0;
}

BackendStatus backendStatus(BackendChoice asked, const BackendState& state) {
  if (state.problem.empty()) return {DiagnosticStatus::OK, ""};
  if (state.partly) {
    return {DiagnosticStatus::WARN,
            "one of the CUDA devices failed and is not used until this process restarts: " +
                state.problem};
  }
  return {levelOf(asked, state.fault),
          "contacts are computed on the CPU, because CUDA cannot be used: " + state.problem +
              adviceOf(state)};
}

}  // namespace deformable_contact_monitor
