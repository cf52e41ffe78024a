// Vectors of four floats or ints that one instruction works on, and loops that are compiled for
// wider vectors too.
#pragma once

namespace deformable_contact_monitor {

using FloatLanes = float __attribute__((vector_size(16)));
using IntLanes = int __attribute__((vector_size(16)));

// Returns the sign of each lane as a bit, the first lane's lowest. The lanes of a comparison are
// negative where it holds.
inline int laneBits(const IntLanes& lanes) {
#ifdef __SSE__
  return __builtin_ia32_movmskps(reinterpret_cast<const FloatLanes&>(lanes));
#else
  const IntLanes bits = (lanes < 0) & IntLanes{1, 2, 4, 8};
  return bits[0] | bits[1] | bits[2] | bits[3];
#endif
}

}  // namespace deformable_contact_monitor

// Marks a function that is compiled for AVX2 too; the program takes that version at its start where
// the processor has AVX2. ThreadSanitizer does not run yet when the version is chosen.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define DCM_WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define DCM_WIDE_CLONES
#endif
