// What measure_trade --swept writes: tables, JSON, a few lines for people.
#pragma once

#include <string>
#include <vector>

#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/motion_statistics.h"
#include "tools/measure_trade/trade_arguments.h"

namespace deformable_contact_monitor {

// What was found, counted at one level.
struct MotionCounts {
  struct Way {
    LostContacts contacts;
    FoundOnsets onsets;
  };
  MotionLevel level = MotionLevel::kBodies;
  std::vector<Onset> truth;
  std::vector<Way> ways;  // of waysToLook(), in its order
};

MotionCounts countMotions(const MotionResults& found, MotionLevel level);

// A row for each level and way.
std::string motionsCsv(const MotionResults& found, const std::vector<MotionCounts>& levels);

// A row for each true onset: when, in frames from 0, and when each way sees it; empty: it does not.
// Of pairs of bodies, the triangles are empty.
std::string onsetsCsv(const MotionResults& found, const std::vector<MotionCounts>& levels,
                      const FrameSource& frames);

std::string motionJson(const TradeArguments& arguments, const MotionResults& found,
                       const std::vector<MotionCounts>& levels, const FrameSource& frames);

// Who loses how much.
std::string motionText(const MotionResults& found, const std::vector<MotionCounts>& levels);

}  // namespace deformable_contact_monitor
