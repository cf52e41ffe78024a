// Decides how each pair of bodies stands after one cycle.
#pragma once

#include <deformable_contact_monitor/ContactState.h>
#include <ros/time.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/body_distance.h"
#include "core/detector.h"
#include "core/vector3.h"
#include "monitor/cycle_report.h"
#include "monitor/rules/parameters.h"
#include "monitor/state/pair_summary.h"

namespace deformable_contact_monitor {

// The rules by which states and events follow from cycles.
struct StateRules {
  int debounce_on_cycles = 1;   // a contact begins after so many cycles of CONTACT in a row, >= 1
  int debounce_off_cycles = 1;  // a contact ends after so many cycles without it in a row, >= 1
  double max_age_s = 0.5;       // a state becomes UNKNOWN when its data are older than this
  // The share [0, 1] of a body's triangles that may be rejected, because a vertex is not finite,
  // while NONE and NEAR are still reported for the body.
  double tolerated_rejects = 0;
  // A state that returns after an UNKNOWN shorter than this keeps its `since`, >= 0.
  double since_survives_s = 0;
  // The tolerance of the detection's options [m], with which DetectionResult::distances were found.
  float tolerance_m = 0;
};

// Returns the rules that the parameters set.
StateRules stateRules(const MonitorParameters& parameters);

// The bounds of a pair's distance, where a bounded detection found some. It is a view of the
// report's result.
struct PairBounds {
  const BodyDistance* bounds = nullptr;  // never null
  PairDecision decision = PairDecision::kOpen;

  bool touches() const { return decision == PairDecision::kContact; }
  // Returns whether the two surfaces are certain not to touch.
  bool isApart() const {
    return decision == PairDecision::kNone || decision == PairDecision::kNear;
  }
  // Returns the unit vector from the witness's point on body a to that on body b; zero if the two
  // are the same up to rounding.
  Vec3d normal() const;
};

// Returns the bounds of a pair's distance, decided by the margins of the report's scene; nothing if
// the detection has no bounds of the pair, so that its contacts and nearest pairs say everything.
std::optional<PairBounds> boundsOf(const CycleReport& report, const MonitoredPair& pair,
                                   float tolerance_m);

// Returns the nearest pair that the detection found of two bodies, or of a part of one and the
// other body; null if it found none.
const NearestPair* nearestOf(const CycleReport& report, const MonitoredPair& pair);

// Where two bodies are nearest to each other, in the scene frame [m].
struct NearPoints {
  Vec3f point_a, point_b;
  Vec3f normal;  // unit vector from a to b; zero if the points are the same up to rounding
  float distance_m = 0;
};

// Returns the nearest points of a pair that is NEAR at the report's stamp; nothing if it is not.
std::optional<NearPoints> nearPoints(const CycleReport& report, const MonitoredPair& pair,
                                     const StateRules& rules);

// Returns why a body, or a part of it, is not known in this cycle; empty if it is known.
std::string bodyProblem(const BodyStatus& body, PartId part);

// Returns why a body of the pair, or its part, is not known in this cycle; empty if both are known.
std::string bodyProblem(const CycleReport& report, const MonitoredPair& pair);

// The contacts of a pair in its time interval (motion: swept).
struct IntervalFinding {
  ros::Time from;       // where the interval starts; zero if there is none
  PairSummary passed;   // triangle pairs that touched in the interval, where they are at its end
  float first_low = 0;  // part [0, 1] of the interval before which there was certainly no contact
  // Why the pair may have touched unnoticed; empty if `passed` says all.
  std::string problem;
  bool has_interval = true;  // if false, the problem is that there is nothing to start from

  bool touched() const { return passed.count > 0; }
  // Turns a NONE or NEAR of the pair into PASSED.
  void setPassed(ContactState* state) const;
};

// The states of all pairs by the report of one cycle. It knows nothing of earlier cycles.
class PairStates {
 public:
  // Both arguments must outlive this. Sums up all contacts, on several threads if there are many.
  PairStates(const CycleReport& report, const StateRules& rules);

  // Returns the state of a pair of this cycle at the report's stamp: NONE, NEAR, CONTACT, or
  // UNKNOWN with its reason. distance_low [m] is valid for UNKNOWN, too.
  ContactState atStamp(const MonitoredPair& pair) const;

  // Returns what the interval of the pair says; without a problem and without contacts if there is
  // no interval because motion is instant.
  IntervalFinding inInterval(const MonitoredPair& pair) const;

 private:
  using BodyPair = std::pair<BodyId, BodyId>;
  struct Interval {
    const SweepReport* sweep;
    PairSummaries touched;
    std::map<PartPair, float> first_low;
  };

  std::string intervalProblem(const SweepReport& sweep, const MonitoredPair& pair) const;

  const CycleReport& report_;
  const StateRules& rules_;
  const PairSummaries at_stamp_;
  std::vector<Interval> intervals_;
  std::map<BodyPair, std::size_t> interval_of_;  // index into intervals_
};

}  // namespace deformable_contact_monitor
