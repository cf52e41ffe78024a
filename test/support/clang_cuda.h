// Lets clang-tidy read .cu and .cuh files: clang 14 knows no CUDA behind 11.5, and its own wrapper
// of CUDA's headers fails on later ones. Included ahead of a file that is read as CUDA for the
// host, without that wrapper (test/tidy.sh has the flags); nothing is ever built with it.
#pragma once

// NOLINTBEGIN(bugprone-reserved-identifier): these names are CUDA's.
// What nvcc defines. cub asks for its version.
#define __CUDACC__ 1
#define __NVCC__ 1
#define __CUDACC_VER_MAJOR__ (CUDART_VERSION / 1000)
#define __CUDACC_VER_MINOR__ (CUDART_VERSION % 1000 / 10)
#define __CUDACC_VER_BUILD__ 0

// CUDA's declarations of C's math functions, and its bodies for the host, clash with clang's own.
#define __MATH_FUNCTIONS_H__
#define __DEVICE_FUNCTIONS_HPP__
#define __noinline__                          // an attribute that nothing here depends on
#define __syncthreads syncThreadsOfClangTidy  // clang has a builtin of that name
// NOLINTEND(bugprone-reserved-identifier)

// The headers up to the pragma declare functions for the host alone. All that follows the pragma
// becomes host and device code. vector_types.h defines __host__ and __device__, so it comes first.
// clang-format off
#include <vector_types.h>
// clang-format on

#include <cxxabi.h>
#include <stdlib.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <variant>

#pragma clang force_cuda_host_device begin
#define clock clockOfClangTidy  // the system's is the host's alone by now
#include <cuda_runtime.h>
#undef clock

#include <algorithm>
#include <cmath>

using std::isnan;
using std::max;
using std::min;
