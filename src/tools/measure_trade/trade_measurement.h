// Runs settings over a sequence of frames and holds what they find against the exact contacts.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/detector.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_grid.h"
#include "tools/measure_trade/trade_statistics.h"

namespace deformable_contact_monitor {

using SayProgress = std::function<void(const std::string&)>;

// The contacts of every frame, by the CPU backend's exact and complete setting.
struct ExactResults {
  std::vector<std::vector<TrianglePair>> contacts;  // per frame
  std::vector<std::string> labels;                  // per frame
  std::vector<BodyPair> bodies;                     // with a contact in some frame, ascending
};

// All cores. Throws std::runtime_error if there is no frame.
ExactResults exactResults(FrameSource* frames, AdjacentPairs adjacent, const SayProgress& progress);

struct CycleCounts {
  int warm_up = 0;  // cycles first, which are not counted; then from the first frame
  int passes = 1;   // through all frames
};

struct Measurement {
  struct Bodies {
    RateOverFrames recall;
    OnsetDelay onset;
  };
  Setting setting;
  std::vector<double> round_trip_ms;  // per cycle: scene on the host to sorted contacts there
  std::vector<std::size_t> repeats;   // cycles of each
  RateOverFrames external, self;      // recall, of contacts between bodies and within one
  RateOverFrames precision;
  std::map<BodyPair, Bodies> bodies;  // of ExactResults::bodies
  OnsetDelay onset;                   // of all pairs of bodies
  Counters work;                      // sums over the cycles
  bool guaranteed = true;             // in every cycle
  std::string broken;  // how a guaranteed setting erred, one line; empty, as it must be: not at all

  Worth worth() const;
};

// Once more, added to what was measured of that setting before. The detector is new or reset.
// Throws std::runtime_error where contacts were left out for want of device memory.
void measure(FrameSource* frames, const ExactResults& exact, const CycleCounts& cycles,
             Detector* detector, const SayProgress& progress, Measurement* sum);

}  // namespace deformable_contact_monitor
