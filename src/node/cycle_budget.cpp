// By when a cycle's detection must end, so that its states go out within a budget.
#include "node/cycle_budget.h"

#include <algorithm>
#include <functional>
#include <vector>

namespace deformable_contact_monitor {

SteadyTime CycleBudget::deadline(SteadyTime arrival) const {
  if (budget_s_ == 0) return SteadyTime::max();
  // All but the longest: one hiccup is not what publishing takes.
  std::vector<double> longest(2);
  std::partial_sort_copy(publishing_s_.begin(), publishing_s_.end(), longest.begin(), longest.end(),
                         std::greater<>());
  const double reserve_s = publishing_s_.size() < 2 ? longest.front() : longest.back();
  return arrival + fromSeconds(budget_s_ - std::min(reserve_s, budget_s_ / 2));
}

void CycleBudget::record(SteadyTime deadline, SteadyTime detected, SteadyTime published) {
  constexpr std::size_t kLatest = 100;
  publishing_s_.push_back(std::max(0.0, toSeconds(published - std::min(deadline, detected))));
  if (publishing_s_.size() > kLatest) publishing_s_.pop_front();
}

}  // namespace deformable_contact_monitor
