#include "core/interval_scan.h"

#include <cstring>

// Wide vectors where the processor has them.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define DCM_WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define DCM_WIDE_CLONES
#endif

namespace deformable_contact_monitor {

DCM_WIDE_CLONES std::size_t scanRow(std::uint32_t row, PackedBox box, const std::uint32_t* lo,
                                    const std::uint32_t* hi, std::uint32_t begin, std::uint32_t end,
                                    Hit* hits) {
  const std::uint32_t guarded = box.hi | kPackedGuard;
  Hit* next = hits;
  for (std::uint32_t chunk = begin; chunk < end; chunk += kScanChunk) {
    // As overlap(PackedBox, PackedBox), for a whole chunk without a branch. (Pointers, because an
    // unsigned index might wrap, and that would keep the loop from being vectorised.)
    const std::uint32_t* chunk_lo = lo + chunk;
    const std::uint32_t* chunk_hi = hi + chunk;
    std::uint8_t hit[kScanChunk];
    for (std::size_t k = 0; k < kScanChunk; ++k) {
      const std::uint32_t both =
          (guarded - chunk_lo[k]) & ((chunk_hi[k] | kPackedGuard) - box.lo) & kPackedGuard;
      hit[k] = both == kPackedGuard;
    }
    for (std::uint32_t k = 0; k < kScanChunk; k += 8) {
      std::uint64_t word;
      std::memcpy(&word, hit + k, 8);
      for (; word != 0; word &= word - 1) {
        *next++ = {row, chunk + k + static_cast<std::uint32_t>(__builtin_ctzll(word)) / 8};
      }
    }
  }
  while (next != hits && next[-1].b >= end) --next;  // read on past the end
  return static_cast<std::size_t>(next - hits);
}

}  // namespace deformable_contact_monitor
