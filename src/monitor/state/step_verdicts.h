// What the steps that end with a cycle say of each pair of bodies.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "monitor/cycle_report.h"
#include "monitor/state/pair_summary.h"

namespace deformable_contact_monitor {

struct StepVerdict {
  PairSummary passed;   // triangle pairs that touched in the step, where they are at its end
  float first_low = 0;  // of the step [0, 1]: certainly no contact before
  // Why they may have touched unseen since the previous cycle; empty: they have not, or `passed`
  // says so.
  std::string problem;
  bool has_step = true;  // else the problem is that there was nothing to start from

  bool touched() const { return passed.count > 0; }
};

class StepVerdicts {
 public:
  // The report must outlive this. tolerated_rejects: as in StateRules.
  StepVerdicts(const CycleReport& report, double tolerated_rejects);

  // Of a pair that the cycle looked at. In instant motion it says nothing.
  StepVerdict of(const MonitoredPair& pair) const;

 private:
  struct OfStep {
    PairSummaries touched;
    std::map<std::pair<BodyId, BodyId>, float> first_low;
  };

  std::string problemOf(const SweepReport& sweep, const MonitoredPair& pair) const;

  const CycleReport& report_;
  const double tolerated_rejects_;
  std::map<std::pair<BodyId, BodyId>, std::size_t> step_of_;  // of report_.sweeps
  std::vector<OfStep> steps_;                                 // as those
};

}  // namespace deformable_contact_monitor
