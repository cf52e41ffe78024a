// Writes the results of measure_trade --swept: tables, JSON, and a few lines for people.
//
// Contacts and onsets are reported at two levels: pairs of bodies, and pairs of triangles.
#pragma once

#include <string>
#include <vector>

#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/motion_measurement.h"
#include "tools/measure_trade/trade_arguments.h"

namespace deformable_contact_monitor {

// The contacts and onsets that each way finds, counted at one level.
struct MotionCounts {
  // The contacts and onsets of one way.
  struct Way {
    PairCounts contacts;
    FoundOnsets onsets;
  };
  MotionLevel level = MotionLevel::kBodies;
  std::vector<Onset> truth;
  std::vector<Way> ways;  // in the order of waysToLook()
};

// Counts what each way finds and loses at a level.
MotionCounts countMotions(const MotionResults& found, MotionLevel level);

// Returns a table with a row for each level and way.
std::string motionsCsv(const MotionResults& found, const std::vector<MotionCounts>& levels);

// Returns a table with a row for each true onset: its time, in frames counted from 0, and the time
// at which each way finds it; empty: it does not. For pairs of bodies, the triangles are empty.
std::string onsetsCsv(const MotionResults& found, const std::vector<MotionCounts>& levels,
                      const FrameSource& frames);

// Returns the content of summary.json.
std::string motionJson(const TradeArguments& arguments, const MotionResults& found,
                       const std::vector<MotionCounts>& levels, const FrameSource& frames);

// Returns a line for each way that says how much it loses.
std::string motionText(const MotionResults& found, const std::vector<MotionCounts>& levels);

}  // namespace deformable_contact_monitor
