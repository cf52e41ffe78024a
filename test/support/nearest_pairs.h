// Compares lists of nearest pairs.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "core/detector.h"

namespace deformable_contact_monitor {

inline testing::AssertionResult sameNearest(const std::vector<NearestPair>& expected,
                                            const std::vector<NearestPair>& found) {
  const auto print = [](const std::vector<NearestPair>& pairs) {
    testing::Message message;
    for (const NearestPair& p : pairs) {
      message << "\n  " << p.pair.body_a << " " << p.pair.triangle_a << ", " << p.pair.body_b << " "
              << p.pair.triangle_b << ": " << p.distance_m << " m, from (" << p.point_a.x << ", "
              << p.point_a.y << ", " << p.point_a.z << ") to (" << p.point_b.x << ", "
              << p.point_b.y << ", " << p.point_b.z << "), along (" << p.normal.x << ", "
              << p.normal.y << ", " << p.normal.z << ")";
    }
    return message;
  };
  if (expected == found) return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << "found" << print(found) << "\ninstead of" << print(expected);
}

}  // namespace deformable_contact_monitor
