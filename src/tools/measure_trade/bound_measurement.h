// Measures what tolerances and time budgets cost, and compares the states of pairs of bodies with
// the exact ones.
//
// A detector with a tolerance promises that NONE is certain, and that a contact has a witness: a
// pair of triangles within the tolerance. The measurement checks both in every detection.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "core/detector.h"
#include "core/predicates/triangle.h"
#include "core/tiling_cache.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_measurement.h"

namespace deformable_contact_monitor {

// A setting of --tolerance. Neither tolerance nor budget: exact detection.
struct BoundSetting {
  float tolerance_m = 0;
  double budget_ms = 0;  // time limit of each detection [ms]; 0: none
  std::string backend = "cpu";
  float overlap = 1;  // below 1, contacts may be missed

  bool isBounded() const { return tolerance_m > 0 || budget_ms > 0; }
};

// Returns the setting in words: "exact", "tolerance 0.005 m", "tolerance 0 m, budget 5 ms", "exact,
// cuda", "overlap 0.5".
std::string describe(const BoundSetting& setting);

// Sums over all cycles. A pair is a pair of two bodies.
struct BoundMeasurement {
  BoundSetting setting;
  std::vector<double> ms;      // time of each detection [ms]
  std::uint64_t pairs = 0;     // pairs that were checked
  std::uint64_t decided = 0;   // pairs that are not UNKNOWN
  std::uint64_t rejected = 0;  // invalid triangles, over all frames
  PairCounts contacts;         // pairs that intersect, and those that are claimed: state CONTACT
  std::uint64_t missed = 0;    // contacts that are reported as none: a defect if overlap is 1
  double largest_claim_m = 0;  // largest triangleGapM() of a claimed contact [m]
  std::string broken;          // the first broken promise; empty: none

  // Returns the share of pairs that are not UNKNOWN.
  double decidedShare() const;
  // Returns the 99th percentile of the times over the budget; 0 without a budget.
  double p99OverBudget() const;
};

// Returns the distance of two finite triangles, which may be degenerate [m]; 0 if they intersect.
// It checks what a detector claims, and shares no code with it. It computes in double, so the error
// is about 1e-15 of the largest coordinate.
double triangleGapM(const Triangle& a, const Triangle& b);

// The pairs of two bodies that intersect, by frame.
using TouchingPairs = std::vector<std::set<BodyPair>>;

// Finds them with a detector that has no tolerance and no budget. Throws std::runtime_error if no
// frame has an enabled pair of two bodies.
TouchingPairs touchingBodies(FrameSource* frames, Detector* exact, const Options& options,
                             const SayProgress& progress);

// Runs sum->setting over the frames, after some warm-up cycles, and adds to `sum`. `tilings` are
// those of the detector, and are built before each detection; null: it has none. `options` has
// everything that the setting does not vary.
void measureBounds(FrameSource* frames, const TouchingPairs& truth, const CycleCounts& cycles,
                   const Options& options, Detector* detector, TilingCache* tilings,
                   BoundMeasurement* sum);

}  // namespace deformable_contact_monitor
