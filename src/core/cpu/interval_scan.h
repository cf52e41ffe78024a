// The innermost loop of the sweep: which packed boxes of a range intersect a row's.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/common/index.h"
#include "core/rules/intervals.h"

namespace deformable_contact_monitor {

// Two positions in a sorted cluster, whose boxes along its axes intersect.
struct BoxPair {
  SortedIndex a, b;
};

// The arrays may be read, and `found` written, this much past the range.
constexpr std::uint32_t kScanChunk = 32;

// Packed boxes by place, as two arrays.
struct PackedColumns {
  const std::uint32_t *lo, *hi;

  PackedBox box(std::uint32_t place) const { return {lo[place], hi[place]}; }
};

// The places in [begin, end) whose intervals begin at `most` at the latest.
struct ScanRange {
  const float* lo;  // by place, ascending in the range; may be read as far past it
  float most;
  std::uint32_t begin, end;
};

struct ScanCounts {
  std::size_t found;
  std::uint32_t overlaps;  // places in the range
};

// Writes each place in the range whose box intersects that of the row, ascending.
ScanCounts scanRow(SortedIndex row, const PackedColumns& boxes, const ScanRange& range,
                   SortedIndex* found);

// The same of moving boxes.
ScanCounts scanRow(SortedIndex row, const PackedColumns& from, const PackedColumns& to,
                   const ScanRange& range, SortedIndex* found);

}  // namespace deformable_contact_monitor
