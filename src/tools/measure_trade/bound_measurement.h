// What tolerances and budgets cost, and what they say of pairs of bodies, against the exact states.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/detector.h"
#include "core/tiling_cache.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_measurement.h"

namespace deformable_contact_monitor {

struct BoundSetting {
  float tolerance_m = 0;
  double budget_ms = 0;  // of each detection; 0: none
  std::string backend = "cpu";
  float overlap = 1;  // below, contacts may be missed

  bool isBounded() const { return tolerance_m > 0 || budget_ms > 0; }
};

// "exact", "tolerance 0.005 m", "tolerance 0 m, budget 5 ms", "exact, cuda", "overlap 0.5".
std::string describe(const BoundSetting& setting);

// Over all cycles; pairs are those of two bodies.
struct BoundMeasurement {
  BoundSetting setting;
  std::vector<double> ms;      // of each detection
  std::uint64_t pairs = 0;     // looked at
  std::uint64_t decided = 0;   // of them
  std::uint64_t contacts = 0;  // that intersect
  std::uint64_t claimed = 0;   // that are said to be in contact
  std::uint64_t common = 0;    // claimed contacts that intersect
  std::uint64_t missed = 0;    // contacts that are said to be none: a defect while overlap is 1
  double largest_claim_m = 0;  // distance at a claimed contact, by triangleGapM()
  std::string broken;          // what is not as promised, the first; empty: nothing

  double recall() const;     // 1 where there is none to find
  double precision() const;  // 1 where nothing is claimed
  double decidedShare() const;
  // Of p99 over the budget; 0: there is none.
  double p99OverBudget() const;
};

// Pairs of two bodies that intersect, by frame.
using TouchingBodies = std::vector<std::set<BodyPair>>;

// By a detector without bounds.
TouchingBodies touchingBodies(FrameSource* frames, Detector* exact, const Options& options,
                              const SayProgress& progress);

// Runs the setting over the frames, after some that do not count, and adds to `sum`. `tilings`:
// those of the detector, made before each detection; null: it has none. options: all that the
// setting does not say.
void measureBounds(FrameSource* frames, const TouchingBodies& truth, const CycleCounts& cycles,
                   const Options& options, Detector* detector, TilingCache* tilings,
                   BoundMeasurement* sum);

}  // namespace deformable_contact_monitor
