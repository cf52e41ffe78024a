// The innermost loop of the sweep: which packed boxes of a range intersect a row's.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/index.h"
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

// Writes each place in [begin, end) whose box intersects that of the row, ascending; returns how
// many.
std::size_t scanRow(SortedIndex row, const PackedColumns& boxes, std::uint32_t begin,
                    std::uint32_t end, SortedIndex* found);

// The same of moving boxes.
std::size_t scanRow(SortedIndex row, const PackedColumns& from, const PackedColumns& to,
                    std::uint32_t begin, std::uint32_t end, SortedIndex* found);

}  // namespace deformable_contact_monitor
