// How far apart the bodies of a pair are, where a bounded detection says it.
#pragma once

#include <optional>

#include "core/body_distance.h"
#include "core/detector.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// A view of the report's result.
struct PairDistance {
  const BodyDistance* bounds = nullptr;  // never null
  PairDecision decision = PairDecision::kOpen;

  bool touches() const { return decision == PairDecision::kContact; }
  // Whether its two surfaces have nothing in common, for certain.
  bool isApart() const {
    return decision == PairDecision::kNone || decision == PairDecision::kNear;
  }
  // Middle between the witness's points [m]. Only where there is a witness.
  Vec3d centroid() const;
  // Unit vector from the witness's point on a to that on b; zero where they are one, but for
  // rounding.
  Vec3d normal() const;
};

// Nothing: the detection looked at no bounds of the pair, so its contacts say all. Of the margins
// of the report's scene.
std::optional<PairDistance> distanceOf(const CycleReport& report, const MonitoredPair& pair,
                                       float tolerance_m);

}  // namespace deformable_contact_monitor
