// Measures what a margin costs: the search for the nearest pair of two bodies, beside the list of
// all triangles within the margin.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/detector.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_measurement.h"

namespace deformable_contact_monitor {

// What a detection does with a margin.
enum class MarginUse {
  kIgnored,    // only contacts that touch, as with a margin of 0
  kNearest,    // Options::nearest: the distance and the nearest pair of each two bodies
  kNearPairs,  // all triangles within the margin are listed
};

// Returns "touching", "nearest" or "near_pairs".
const char* toString(MarginUse use);

// A setting of --margins.
struct MarginSetting {
  std::string backend = "cpu";
  float margin_m = 0;
  MarginUse use = MarginUse::kIgnored;
};

// Returns the setting in words, such as "nearest, margin 0.1 m".
std::string describe(const MarginSetting& setting);

// Sums over all cycles. A pair of bodies is two different bodies.
struct MarginMeasurement {
  MarginSetting setting;
  std::vector<double> ms;            // time of each detection [ms]
  std::uint64_t body_pairs = 0;      // pairs of bodies within the margin, or that touch
  std::uint64_t triangle_pairs = 0;  // triangles that were listed
  std::uint64_t rejected = 0;        // invalid triangles, over all frames
  std::string broken;                // the first difference from other settings; empty: none
};

// The least distance of each two bodies that are within a margin [m], by frame.
using FrameDistances = std::vector<std::vector<std::pair<BodyPair, float>>>;

// Runs sum->setting over the frames, after some warm-up cycles, and adds to `sum`. The frames get
// the margin. Returns the distances of the last pass; each frame's ascend by bodies. They are 0 for
// bodies that touch, and empty if margins are ignored. `options` has everything that the setting
// does not vary.
FrameDistances measureMargin(FrameSource* frames, const CycleCounts& cycles, const Options& options,
                             Detector* detector, MarginMeasurement* sum);

// Says how the distances differ from those of another setting with the same margin: sets
// sum->broken. They must be the same up to rounding.
void compareDistances(const FrameDistances& expected, const FrameDistances& found,
                      MarginMeasurement* sum);

}  // namespace deformable_contact_monitor
