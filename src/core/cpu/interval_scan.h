// The innermost loop of the sweep: finds which quantised boxes of a range intersect a row's box.
//
// It works on chunks of 32 columns without a branch, and is compiled for AVX2 too.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/common/index.h"
#include "core/rules/intervals.h"

namespace deformable_contact_monitor {

// Two positions in a sorted cluster whose quantised boxes intersect.
struct BoxPair {
  SortedIndex a, b;
};

// Both the arrays and `found` need this much room past the end: a scan reads and writes whole
// chunks.
constexpr std::uint32_t kScanChunk = 32;

// Quantised boxes by position, as two arrays.
struct PackedColumns {
  const std::uint32_t *lo, *hi;

  PackedBox box(std::uint32_t place) const { return {lo[place], hi[place]}; }
};

// The positions in [begin, end) whose intervals begin at `most` or below.
struct ScanRange {
  const float* lo;  // by position, ascending in the range; has a chunk of room past it
  float most;
  std::uint32_t begin, end;
};

// Counts what a scan has found.
struct ScanCounts {
  std::size_t found;
  std::uint32_t overlaps;  // positions in the range
};

// Writes to `found` each position in the range whose box intersects the box of `row`, ascending.
ScanCounts scanRow(SortedIndex row, const PackedColumns& boxes, const ScanRange& range,
                   SortedIndex* found);

// Does the same for moving boxes: `from` at the begin of the time interval, `to` at its end.
ScanCounts scanRow(SortedIndex row, const PackedColumns& from, const PackedColumns& to,
                   const ScanRange& range, SortedIndex* found);

}  // namespace deformable_contact_monitor
