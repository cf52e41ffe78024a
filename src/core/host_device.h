// Marks functions that both backends run. The marks are empty if the compiler is not nvcc.
#pragma once

#ifdef __CUDACC__
#define DCM_HD __host__ __device__
#else
#define DCM_HD
#endif

// Marks functions with long code that runs rarely. Not inlining them keeps the common path small on
// the host, and compilation short on the device.
#define DCM_RARE __attribute__((noinline))

// Stands before a loop whose code runs rarely, or once in a kernel. Not unrolling it keeps the code
// short on the device, which otherwise waits for its instructions.
#ifdef __CUDA_ARCH__
#define DCM_ROLLED _Pragma("unroll 1")
#else
#define DCM_ROLLED
#endif
