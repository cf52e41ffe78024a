// What a tolerance and a budget cost: which pairs were decided, and when the states were out.
#include "monitor/diagnostics/trade_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "monitor/state/pair_distance.h"

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

std::set<std::pair<BodyId, BodyId>> bodiesInContact(const DetectionResult& result) {
  std::set<std::pair<BodyId, BodyId>> bodies;
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    if (!result.separations_m.empty() && result.separations_m[i] > 0) continue;  // near
    bodies.insert({result.contacts[i].body_a, result.contacts[i].body_b});
  }
  return bodies;
}

}  // namespace

void TradeWatch::record(const CycleReport& report, double answer_s) {
  constexpr std::size_t kLatest = 200;
  if (report.result == nullptr) return;
  Cycle cycle{0, 0, answer_s};
  const auto touching = bodiesInContact(*report.result);
  for (const auto& [a, b] : report.scene->enabledPairs()) {
    const std::optional<PairDistance> distance =
        distanceOf(report, {a, b, false}, static_cast<float>(tolerance_m_));
    const bool is_decided = distance ? distance->decision != PairDecision::kOpen
                                     : !report.result->cut_off || touching.count({a, b}) > 0;
    ++cycle.pairs;
    cycle.decided += is_decided ? 1 : 0;
  }
  cycles_.push_back(cycle);
  if (cycles_.size() > kLatest) cycles_.pop_front();
}

void TradeWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  constexpr double kLate = 1.1;
  std::uint64_t pairs = 0, decided = 0;
  std::vector<double> answers_s;
  for (const Cycle& cycle : cycles_) {
    pairs += cycle.pairs;
    decided += cycle.decided;
    answers_s.push_back(cycle.answer_s);
  }
  std::sort(answers_s.begin(), answers_s.end());
  const auto answerMs = [&](std::size_t percent) {
    return answers_s.empty() ? 0 : 1e3 * answers_s[(answers_s.size() - 1) * percent / 100];
  };
  const bool is_late = budget_s_ > 0 && answerMs(99) > kLate * 1e3 * budget_s_;
  status.summary(is_late ? DiagnosticStatus::WARN : DiagnosticStatus::OK,
                 is_late ? "states come later than budget_ms" : "in force");
  status.add("tolerance [m]", tolerance_m_);
  status.add("budget [ms]", 1e3 * budget_s_);
  status.addf(
      "pairs of bodies decided", "%.2f %%",
      pairs == 0 ? 100.0 : 100.0 * static_cast<double>(decided) / static_cast<double>(pairs));
  status.addf("arrival to states [ms]", "median %.3f, p99 %.3f, max %.3f", answerMs(50),
              answerMs(99), answerMs(100));
  if (budget_s_ > 0) status.addf("p99 over budget", "%.2f", answerMs(99) / (1e3 * budget_s_));
}

}  // namespace deformable_contact_monitor
