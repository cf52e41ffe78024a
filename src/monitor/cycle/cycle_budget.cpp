// By when a cycle's detection must end, so that its states go out within a budget.
#include "monitor/cycle/cycle_budget.h"

#include <algorithm>

namespace deformable_contact_monitor {

SteadyTime CycleBudget::deadline(SteadyTime arrival) const {
  if (budget_s_ == 0) return SteadyTime::max();
  return std::max(publishing_.earlier(arrival + fromSeconds(budget_s_)),
                  arrival + fromSeconds(budget_s_ / 2));
}

void CycleBudget::record(SteadyTime deadline, SteadyTime detected, SteadyTime published) {
  publishing_.took(std::max(SteadyTime::duration(0), published - std::min(deadline, detected)));
}

}  // namespace deformable_contact_monitor
