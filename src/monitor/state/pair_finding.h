// What a cycle's detection says of one pair of bodies.
#pragma once

#include <deformable_contact_monitor/ContactState.h>

#include <optional>
#include <string>

#include "monitor/cycle_report.h"
#include "monitor/state/inside_parts.h"
#include "monitor/state/pair_distance.h"
#include "monitor/state/pair_summary.h"
#include "monitor/state/state_rules.h"

namespace deformable_contact_monitor {

// A view of the report.
class PairFinding {
 public:
  // `summary`: of the report's contacts of that pair.
  PairFinding(const CycleReport& report, const MonitoredPair& pair, const PairSummary& summary,
              const StateRules& rules);

  // Why the pair is not known although both bodies are; empty: it is.
  std::string problem() const;

  // NONE, NEAR or CONTACT. Only where there is no problem.
  ContactState state() const;

  // Certain of the pair's distance, also where the problem is that it is not decided [m]; 0:
  // nothing is.
  float distanceLowM() const;

 private:
  bool isContact() const;
  bool isListed() const { return !distance_ || distance_->bounds->is_listed; }
  std::string problemOfResult() const;
  std::string rejectedProblem() const;
  void setPlace(ContactState* state) const;

  const CycleReport& report_;
  const MonitoredPair pair_;
  const PairSummary summary_;
  const StateRules& rules_;
  const InsideParts inside_;
  const std::optional<PairDistance> distance_;
};

}  // namespace deformable_contact_monitor
