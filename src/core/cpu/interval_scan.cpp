#include "core/cpu/interval_scan.h"

#include <array>
#include <cstring>

// Wide vectors where the processor has them. ThreadSanitizer is not up yet when clones are chosen.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define DCM_WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define DCM_WIDE_CLONES
#endif

namespace deformable_contact_monitor {
namespace {

// For each set of eight flags: which are set, ascending, a byte each, and how many.
struct Flags {
  std::array<std::uint8_t, 8> set;
  std::uint8_t count;
};

constexpr std::array<Flags, 256> allFlags() {
  std::array<Flags, 256> table{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((mask >> bit & 1) != 0) {
        table[mask].set[table[mask].count++] = static_cast<std::uint8_t>(bit);
      }
    }
  }
  return table;
}

constexpr std::array<Flags, 256> kFlags = allFlags();

}  // namespace

DCM_WIDE_CLONES std::size_t scanRow(SortedIndex row, PackedBox box, const std::uint32_t* lo,
                                    const std::uint32_t* hi, std::uint32_t begin, std::uint32_t end,
                                    BoxPair* pairs) {
  const std::uint32_t guarded = box.hi | kPackedGuard;
  BoxPair* next = pairs;
  for (std::uint32_t chunk = begin; chunk < end; chunk += kScanChunk) {
    // As intersects(PackedBox, PackedBox), for a whole chunk without a branch. (Pointers, because
    // an unsigned index might wrap, and that would keep the loop from being vectorised.)
    const std::uint32_t* chunk_lo = lo + chunk;
    const std::uint32_t* chunk_hi = hi + chunk;
    std::uint8_t met[kScanChunk];
    for (std::size_t k = 0; k < kScanChunk; ++k) {
      const std::uint32_t both =
          (guarded - chunk_lo[k]) & ((chunk_hi[k] | kPackedGuard) - box.lo) & kPackedGuard;
      met[k] = both == kPackedGuard;
    }
    // Nor a branch on what was found: eight pairs are written, as many are kept as there are. The
    // product gathers the eight flags as bits (little-endian).
    for (std::uint32_t k = 0; k < kScanChunk; k += 8) {
      std::uint64_t word;
      std::memcpy(&word, met + k, 8);
      const Flags& flags = kFlags[word * 0x0102040810204080U >> 56];
      for (int i = 0; i < 8; ++i) next[i] = {row, SortedIndex(chunk + k + flags.set[i])};
      next += flags.count;
    }
  }
  while (next != pairs && next[-1].b.value >= end) --next;  // read on past the end
  return static_cast<std::size_t>(next - pairs);
}

}  // namespace deformable_contact_monitor
