// Streams and events.
#pragma once

#include <cuda_runtime.h>

#include "cuda/device/check.cuh"

namespace deformable_contact_monitor {

// A stream of its own, so that nothing waits for the default one.
class CudaStream {
 public:
  CudaStream() {
    checkCuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
  }
  CudaStream(const CudaStream&) = delete;
  CudaStream& operator=(const CudaStream&) = delete;
  ~CudaStream() { cudaStreamDestroy(stream_); }

  cudaStream_t get() const { return stream_; }
  // Whether all that was put into it is done.
  bool isIdle() const {
    const cudaError_t status = cudaStreamQuery(stream_);
    if (status == cudaErrorNotReady) {
      cudaGetLastError();  // no error
      return false;
    }
    checkCuda(status, "cudaStreamQuery");
    return true;
  }
  void synchronise() { checkCuda(cudaStreamSynchronize(stream_), "cudaStreamSynchronize"); }

 private:
  cudaStream_t stream_ = nullptr;
};

class CudaEvent {
 public:
  CudaEvent() { checkCuda(cudaEventCreate(&event_), "cudaEventCreate"); }
  CudaEvent(const CudaEvent&) = delete;
  CudaEvent& operator=(const CudaEvent&) = delete;
  ~CudaEvent() { cudaEventDestroy(event_); }

  void record(cudaStream_t stream) { checkCuda(tryRecord(stream), "cudaEventRecord"); }
  // For streams of others, which may not do.
  cudaError_t tryRecord(cudaStream_t stream) { return cudaEventRecord(event_, stream); }
  // Makes what is put into the stream from now on wait for what was before the record.
  void makeWait(cudaStream_t stream) const {
    checkCuda(cudaStreamWaitEvent(stream, event_), "cudaStreamWaitEvent");
  }
  // [ms], of two events that have passed.
  static double between(const CudaEvent& start, const CudaEvent& end) {
    float ms = 0;
    checkCuda(cudaEventElapsedTime(&ms, start.event_, end.event_), "cudaEventElapsedTime");
    return ms;
  }

 private:
  cudaEvent_t event_ = nullptr;
};

}  // namespace deformable_contact_monitor
