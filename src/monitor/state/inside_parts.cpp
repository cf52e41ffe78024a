// What of one body of a pair lies within the other.
#include "monitor/state/inside_parts.h"

#include <algorithm>
#include <tuple>
#include <vector>

namespace deformable_contact_monitor {
namespace {

// Of one body within the other, which stand together.
InsideParts partsWithin(const std::vector<InsidePart>& parts, BodyId inner, BodyId outer,
                        std::uint8_t which) {
  const auto first = std::lower_bound(parts.begin(), parts.end(), std::tie(inner, outer),
                                      [](const InsidePart& part, const auto& bodies) {
                                        return std::tie(part.inner, part.outer) < bodies;
                                      });
  InsideParts found;
  double count = 0;
  for (auto part = first; part != parts.end(); ++part) {
    if (part->inner != inner || part->outer != outer) break;
    found.centroid = found.centroid + part->centroid;
    ++count;
  }
  if (count == 0) return found;
  found.which = which;
  found.centroid = found.centroid * (1 / count);
  return found;
}

}  // namespace

InsideParts insidePartsOf(const CycleReport& report, const MonitoredPair& pair) {
  if (report.containment == nullptr) return {};
  const std::vector<InsidePart>& parts = report.containment->parts;
  const InsideParts a_in_b = partsWithin(parts, pair.a, pair.b, 1);
  return a_in_b.any() ? a_in_b : partsWithin(parts, pair.b, pair.a, 2);
}

}  // namespace deformable_contact_monitor
