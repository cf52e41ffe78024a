// Marks functions that both backends run. Empty where the compiler is not nvcc.
#pragma once

#ifdef __CUDACC__
#define DCM_HD __host__ __device__
#else
#define DCM_HD
#endif
