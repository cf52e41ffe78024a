// Loops that are compiled for wide vectors too, which processors that have them take.
#pragma once

// ThreadSanitizer is not up yet when clones are chosen.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define DCM_WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define DCM_WIDE_CLONES
#endif
