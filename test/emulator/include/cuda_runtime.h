#pragma once
#include <math.h>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cuda_runtime_api.h>
#include <vector_functions.h>
#include <vector_types.h>
#include "emu.h"

template <class T>
cudaError_t cudaMalloc(T** p, std::size_t n) { return ::cudaMalloc(reinterpret_cast<void**>(p), n); }
template <class T>
cudaError_t cudaMallocAsync(T** p, std::size_t n, cudaStream_t s) { return ::cudaMallocAsync(reinterpret_cast<void**>(p), n, s); }
template <class T>
cudaError_t cudaHostAlloc(T** p, std::size_t n, unsigned f) { return ::cudaHostAlloc(reinterpret_cast<void**>(p), n, f); }
template <class T>
cudaError_t cudaMallocHost(T** p, std::size_t n, unsigned f = 0) { return ::cudaHostAlloc(reinterpret_cast<void**>(p), n, f); }
template <class T>
cudaError_t cudaMallocManaged(T** p, std::size_t n, unsigned f = 1) { return ::cudaMallocManaged(reinterpret_cast<void**>(p), n, f); }
inline cudaError_t cudaEventCreate(cudaEvent_t* e, unsigned f) { return cudaEventCreateWithFlags(e, f); }
template <class K>
cudaError_t cudaFuncGetAttributes(cudaFuncAttributes* a, K*) { *a = {}; a->ptxVersion = 90; a->binaryVersion = 90; return cudaSuccess; }
template <class K>
cudaError_t cudaFuncSetAttribute(K*, cudaFuncAttribute, int) { return cudaSuccess; }
template <class K>
cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessor(int* n, K*, int threads, std::size_t) {
  *n = threads > 1024 ? 0 : 2;
  return cudaSuccess;
}
template <class... P, class... A>
cudaError_t cudaLaunchKernelEx(const cudaLaunchConfig_t* c, void (*k)(P...), A&&... a) {
  emu::Config(c->gridDim, c->blockDim, c->dynamicSmemBytes, c->stream).run(__PRETTY_FUNCTION__, k, std::forward<A>(a)...);
  return cudaSuccess;
}
