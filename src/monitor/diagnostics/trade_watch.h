// What a tolerance and a budget cost: which pairs were decided, and when the states were out.
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <deque>

#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// One thread at a time.
class TradeWatch {
 public:
  // 0: none.
  TradeWatch(double tolerance_m, double budget_s)
      : tolerance_m_(tolerance_m), budget_s_(budget_s) {}

  // A cycle. `answer_s`: from the arrival of its mesh until its states were out.
  void record(const CycleReport& report, double answer_s);

  // Of the latest 200 cycles: the share of their pairs that were decided, and the times. A warning
  // where one of a hundred answers takes over a tenth longer than the budget.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  struct Cycle {
    std::uint64_t pairs, decided;
    double answer_s;
  };

  double tolerance_m_, budget_s_;
  std::deque<Cycle> cycles_;  // the latest
};

}  // namespace deformable_contact_monitor
