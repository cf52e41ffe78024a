// The steps of a cycle in order: as a CUDA graph, or one after the other with their times.
#pragma once

#include "core/stages.h"
#include "cuda/device/stream.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {

// One recorded cycle and the streams of its branches. The arrays' memory must stay as it is while a
// recording of them is in use: forget() when it moved.
class CycleGraph {
 public:
  CycleGraph() = default;
  CycleGraph(const CycleGraph&) = delete;
  CycleGraph& operator=(const CycleGraph&) = delete;
  ~CycleGraph() { forget(); }

  // Records the cycle if it is not the one recorded last.
  void prepare(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
  void launch(cudaStream_t stream);
  void forget();

  // Runs the steps one by one.
  void runTimed(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
  // What they took, once the stream has been waited for.
  StageTimes times() const;

 private:
  // Beside the stream itself.
  static constexpr int kBranches = 3;
  static constexpr int kSteps = 11;

  // The steps, on `stream` and the branches.
  void enqueue(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

  CycleShape shape_;
  cudaGraphExec_t graph_ = nullptr;
  CudaStream branch_[kBranches];
  CudaEvent started_, done_[kSteps];  // done_: of each step
  CudaEvent mark_[kSteps + 1];        // before each step of a timed run, and behind the last
};

}  // namespace deformable_contact_monitor
