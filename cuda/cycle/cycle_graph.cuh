// Runs the steps of a cycle on the device: as a CUDA graph, or one after the other with timing.
#pragma once

#include <cstddef>
#include <vector>

#include "core/common/stages.h"
#include "cuda/device/stream.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {

// Owns one recorded graph and the streams of its branches. For one thread at a time.
class CycleGraph {
 public:
  CycleGraph() = default;
  CycleGraph(const CycleGraph&) = delete;
  CycleGraph& operator=(const CycleGraph&) = delete;
  ~CycleGraph() { forget(); }

  // Enqueues a cycle, and records `start` when its work begins. A cycle with new arrays or a new
  // shape is launched step by step. If the next cycle has the same ones, the steps are recorded as
  // a graph, which later cycles launch. Recording costs more than one cycle gains, so it waits for
  // the second use. By then all of its kernels have run, so that CUDA neither loads a kernel nor
  // enlarges the memory for stacks while it records or replays. Throws CudaError.
  void run(const CycleArrays& cycle, const CycleShape& shape, CudaEvent& start,
           cudaStream_t stream);

  // Enqueues the steps one by one and records an event between them.
  void runTimed(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
  // Waits for what run() has begun on branches, also if it threw.
  void waitForBranches();
  // Returns the times of the steps of runTimed() [ms]. The stream must have been waited for.
  StageTimes times() const;

 private:
  static constexpr int kBranches = 4;
  static constexpr int kSteps = 13;

  // Returns whether arrays and shape are those of the last cycle, compared byte by byte.
  bool isLast(const CycleArrays& cycle, const CycleShape& shape) const;
  void record(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
  bool update(cudaGraph_t recorded) const;
  void forget();
  // Enqueues the steps on `stream` and the branches.
  void enqueue(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

  CycleShape shape_;
  std::vector<unsigned char> arrays_;  // of the last cycle, as bytes
  bool is_recorded_ = false;           // graph_ holds the last cycle's steps
  cudaGraphExec_t graph_ = nullptr;
  CycleShape graph_shape_;
  std::size_t graph_nodes_ = 0;
  CudaStream branch_[kBranches];
  // The start of a cycle, and the end of each of its steps.
  CudaEvent started_, done_[kSteps];
  // Before each step of a timed run, and after the last one.
  CudaEvent mark_[kSteps + 1];
  bool times_nearest_ = false;  // whether the timed run searched nearest pairs
};

}  // namespace deformable_contact_monitor
