// May two triangles that move on straight lines come within a pad of one another? Of links, whose
// true ways are arcs: their points stay within the pad of the straight ones.
#pragma once

#include "core/predicates/swept_triangle.h"

namespace deformable_contact_monitor {

struct PadVerdict {
  bool may_touch = false;
  float first_low = 0;  // certainly more than the pad apart in [0, first_low)
};

// may_touch is false only if the two, with finite vertices, are certainly more than `pad_m` apart
// at all times of the step. The same bits on host and device, and with a and b swapped.
DCM_HD inline PadVerdict withinPad(const MovingTriangle& a, const MovingTriangle& b, float pad_m) {
  MovingBox grown = boxOf(a);
  grown.from = inflated(grown.from, pad_m);
  grown.to = inflated(grown.to, pad_m);
  return {!areApart(grown, boxOf(b)), 0};
}

}  // namespace deformable_contact_monitor
