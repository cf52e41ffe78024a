// By when a cycle's detection must end, so that its states go out within a budget.
#pragma once

#include "core/bounds/usual_time.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Reads no clock. One thread at a time.
class CycleBudget {
 public:
  // [s], from the arrival of a mesh to its states on the wire; 0: none.
  explicit CycleBudget(double budget_s) : budget_s_(budget_s) {}

  // When the detection of a mesh that came then must end: so much earlier than the budget as
  // publishing took lately, but half of it is the detection's. max(): never.
  SteadyTime deadline(SteadyTime arrival) const;

  // A cycle with that deadline was detected and then published. What a detection takes beyond its
  // deadline counts as publishing.
  void record(SteadyTime deadline, SteadyTime detected, SteadyTime published);

 private:
  double budget_s_;
  UsualTime publishing_;
};

}  // namespace deformable_contact_monitor
