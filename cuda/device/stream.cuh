// Owns CUDA streams and events.
#pragma once

#include <cuda_runtime.h>

#include "cuda/device/check.cuh"

namespace deformable_contact_monitor {

// Owns a stream that does not synchronise with the default stream.
class CudaStream {
 public:
  CudaStream() {
    checkCuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
  }
  CudaStream(const CudaStream&) = delete;
  CudaStream& operator=(const CudaStream&) = delete;
  ~CudaStream() { cudaStreamDestroy(stream_); }

  cudaStream_t get() const { return stream_; }
  // Returns whether all work in the stream is done.
  bool isIdle() const {
    const cudaError_t status = cudaStreamQuery(stream_);
    if (status == cudaErrorNotReady) {
      cudaGetLastError();  // a busy stream is no error
      return false;
    }
    checkCuda(status, "cudaStreamQuery");
    return true;
  }
  void synchronise() { checkCuda(cudaStreamSynchronize(stream_), "cudaStreamSynchronize"); }

 private:
  cudaStream_t stream_ = nullptr;
};

// Owns an event that marks a point in a stream and its time.
class CudaEvent {
 public:
  CudaEvent() { checkCuda(cudaEventCreate(&event_), "cudaEventCreate"); }
  CudaEvent(const CudaEvent&) = delete;
  CudaEvent& operator=(const CudaEvent&) = delete;
  ~CudaEvent() { cudaEventDestroy(event_); }

  void record(cudaStream_t stream) { checkCuda(tryRecord(stream), "cudaEventRecord"); }
  // Records without a check, for streams of the user, where the call may fail.
  cudaError_t tryRecord(cudaStream_t stream) { return cudaEventRecord(event_, stream); }
  // Makes work that is enqueued in the stream from now on wait for the recorded point.
  void makeWait(cudaStream_t stream) const {
    checkCuda(cudaStreamWaitEvent(stream, event_), "cudaStreamWaitEvent");
  }
  // Returns the time between two events that have passed [ms].
  static double between(const CudaEvent& start, const CudaEvent& end) {
    float ms = 0;
    checkCuda(cudaEventElapsedTime(&ms, start.event_, end.event_), "cudaEventElapsedTime");
    return ms;
  }

 private:
  cudaEvent_t event_ = nullptr;
};

}  // namespace deformable_contact_monitor
