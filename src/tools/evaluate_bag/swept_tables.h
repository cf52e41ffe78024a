// The tables of events, and of what touches between the cycles, that an evaluation writes while it
// goes.
#pragma once

#include <string>

#include "tools/evaluate_bag/evaluation_tables.h"

namespace deformable_contact_monitor {

// swept_pairs.csv: a row for each triangle pair of the first run that touches at some time of a
// step. `from` is the step's beginning, its end is `stamp`.
class SweptPairsTable {
 public:
  explicit SweptPairsTable(const std::string& folder);
  void add(const CycleReport& cycle, const RunSteps& steps);
  void finish() { file_.finish(); }

 private:
  TableFile file_;
};

// events.csv: a row for each event of each run, in the order of cycles. Of PASSED, `from` is where
// its step begins.
class EventsTable {
 public:
  explicit EventsTable(const std::string& folder);
  void add(const CycleReport& cycle, const EvaluationRun& run);
  void finish() { file_.finish(); }

 private:
  TableFile file_;
};

}  // namespace deformable_contact_monitor
