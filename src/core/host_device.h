// Marks functions that both backends run. Empty where the compiler is not nvcc.
#pragma once

#ifdef __CUDACC__
#define DCM_HD __host__ __device__
#else
#define DCM_HD
#endif

// For rare, long code: keeps the common path small on the host and compilation short on the device.
#define DCM_RARE __attribute__((noinline))

// Ahead of a loop in long, rare code: keeps it short on the device.
#ifdef __CUDA_ARCH__
#define DCM_ROLLED _Pragma("unroll 1")
#else
#define DCM_ROLLED
#endif
