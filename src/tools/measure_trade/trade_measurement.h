// Runs settings over a sequence of frames, and compares what they find with the exact contacts.
//
// Recall and precision are counted for each frame, because a setting that is good on average may
// lose a whole contact in one frame.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/detector.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_grid.h"
#include "tools/measure_trade/trade_statistics.h"

namespace deformable_contact_monitor {

// Gets a text about what is being measured.
using SayProgress = std::function<void(const std::string&)>;

// The contacts of every frame, found by the CPU backend with exact predicates and overlap 1.
struct ExactResults {
  std::vector<std::vector<TrianglePair>> contacts;  // per frame
  std::vector<std::string> labels;                  // per frame
  std::vector<BodyPair> bodies;                     // with a contact in some frame, ascending
  std::uint64_t rejected = 0;                       // invalid triangles, over all frames
};

// Finds the exact contacts on all cores. Throws std::runtime_error if there is no frame.
ExactResults exactResults(FrameSource* frames, AdjacentPairs adjacent, const SayProgress& progress);

// How many cycles are measured.
struct CycleCounts {
  int warm_up = 0;  // cycles that are not counted; measuring starts at the first frame again
  int passes = 1;   // through all frames
};

// Shows all frames again and again: passes that are not counted until the warm-up is done, then
// cycles.passes that are. Calls visit(frame, is_counted) after each FrameSource::next(); frames
// count from 0.
void forEachCycle(FrameSource* frames, const CycleCounts& cycles,
                  const std::function<void(std::size_t frame, bool is_counted)>& visit);

// Holds what was measured of one setting, summed over its repeats.
struct Measurement {
  // The figures of one pair of bodies.
  struct Bodies {
    RateOverFrames recall;
    OnsetDelay onset;
  };
  Setting setting;
  std::vector<double> round_trip_ms;  // per cycle: from a scene to sorted contacts on the host [ms]
  std::vector<std::size_t> repeats;   // the number of cycles of each repeat
  RateOverFrames external, self;      // recall of contacts between bodies, and of self-contacts
  RateOverFrames precision;
  std::map<BodyPair, Bodies> bodies;  // of ExactResults::bodies
  OnsetDelay onset;                   // of all pairs of bodies
  Counters work;                      // sums over the cycles
  bool guaranteed = true;             // in every cycle
  std::string broken;  // how a guaranteed setting missed a contact: a defect; empty: it did not

  // Returns the criteria by which the setting is compared with others.
  Worth worth() const;
};

// Returns the index of the setting to use in place of `chosen`: that of the default options on the
// same backend, if it finds as much, keeps the budget as well and is no slower beyond the noise of
// the repeats. Otherwise returns `chosen`.
std::size_t defaultsIfAsGood(const std::vector<Measurement>& all, std::size_t chosen,
                             std::optional<double> budget_ms);

// Measures sum->setting once more, and adds to `sum`. The detector must be new or reset. Throws
// std::runtime_error if contacts were left out because device memory was short.
void measure(FrameSource* frames, const ExactResults& exact, const CycleCounts& cycles,
             Detector* detector, const SayProgress& progress, Measurement* sum);

}  // namespace deformable_contact_monitor
