#include "core/cpu/interval_scan.h"

#include <cstring>

#include "core/common/lanes.h"

namespace deformable_contact_monitor {
namespace {

using EightPlaces = std::uint32_t __attribute__((vector_size(32)));

// For each of the 256 sets of eight flags: the numbers of the flags that are set, ascending, and
// how many they are.
struct FlagTable {
  std::uint32_t set[256][8];
  std::uint8_t count[256];
};

constexpr FlagTable allFlags() {
  FlagTable table{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((mask >> bit & 1) != 0) {
        table.set[mask][table.count[mask]++] = bit;
      }
    }
  }
  return table;
}

constexpr FlagTable kFlags = allFlags();

// A row's box against the boxes of many columns, as intersects() for two PackedBoxes.
struct StillRow {
  PackedBox box;
  PackedColumns columns;

  StillRow(const PackedColumns& boxes, SortedIndex row)
      : box(boxes.box(row.value)), columns(boxes) {}

  // The guard bits are set where the row is not below, or not above, the column. (Pointers are used
  // because an unsigned index might wrap around, which would keep the compiler from vectorising the
  // loop over a chunk.)
  std::uint32_t above(std::uint32_t chunk, std::size_t k) const {
    return box.hi - (columns.lo + chunk)[k];
  }
  std::uint32_t below(std::uint32_t chunk, std::size_t k) const {
    return (columns.hi + chunk)[k] - box.lo;
  }
};

// The same for moving boxes: two boxes are apart only if they are so on the same side at both ends.
struct MovingRow {
  StillRow from, to;

  std::uint32_t above(std::uint32_t chunk, std::size_t k) const {
    return from.above(chunk, k) | to.above(chunk, k);
  }
  std::uint32_t below(std::uint32_t chunk, std::size_t k) const {
    return from.below(chunk, k) | to.below(chunk, k);
  }
};

// It is always inlined, so that it is compiled for the same processor as its caller.
template <class Row>
__attribute__((always_inline)) inline ScanCounts scan(const Row& boxes, const ScanRange& range,
                                                      SortedIndex* found) {
  static_assert(sizeof(EightPlaces) == 8 * sizeof(SortedIndex));
  SortedIndex* next = found;
  std::uint32_t overlaps = 0;
  for (std::uint32_t chunk = range.begin; chunk < range.end && range.lo[chunk] <= range.most;
       chunk += kScanChunk) {
    // Tests a whole chunk without a branch.
    const float* const lo = range.lo + chunk;
    const std::uint32_t left = range.end - chunk;
    std::uint8_t met[kScanChunk];
    for (std::uint32_t k = 0; k < kScanChunk; ++k) {
      const bool overlap = (lo[k] <= range.most) & (k < left);
      overlaps += overlap;
      met[k] = ((boxes.above(chunk, k) & boxes.below(chunk, k) & kPackedGuard) == kPackedGuard) &
               overlap;
    }
    // Collects the hits without a branch too: it writes eight positions and advances by the number
    // of hits. The product gathers eight flags as the bits of one byte (on little-endian machines).
    for (std::uint32_t k = 0; k < kScanChunk; k += 8) {
      std::uint64_t word;
      std::memcpy(&word, met + k, 8);
      const std::size_t flags = word * 0x0102040810204080U >> 56;
      EightPlaces places;
      std::memcpy(&places, kFlags.set[flags], sizeof(places));
      places += chunk + k;
      std::memcpy(next, &places, sizeof(places));
      next += kFlags.count[flags];
    }
  }
  return {static_cast<std::size_t>(next - found), overlaps};
}

}  // namespace

DCM_WIDE_CLONES ScanCounts scanRow(SortedIndex row, const PackedColumns& boxes,
                                   const ScanRange& range, SortedIndex* found) {
  return scan(StillRow(boxes, row), range, found);
}

DCM_WIDE_CLONES ScanCounts scanRow(SortedIndex row, const PackedColumns& from,
                                   const PackedColumns& to, const ScanRange& range,
                                   SortedIndex* found) {
  return scan(MovingRow{{from, row}, {to, row}}, range, found);
}

}  // namespace deformable_contact_monitor
