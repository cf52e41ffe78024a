// The steps of a cycle in order: as a CUDA graph, or one after the other with their times.
#pragma once

#include <cstddef>
#include <vector>

#include "core/common/stages.h"
#include "cuda/device/stream.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {

// One recorded cycle and the streams of its branches.
class CycleGraph {
 public:
  CycleGraph() = default;
  CycleGraph(const CycleGraph&) = delete;
  CycleGraph& operator=(const CycleGraph&) = delete;
  ~CycleGraph() { forget(); }

  // Runs a cycle; records `start` as its work begins. What comes for the first time is launched
  // step by step; the second time it is recorded, for that takes longer than one cycle gains.
  void run(const CycleArrays& cycle, const CycleShape& shape, CudaEvent& start,
           cudaStream_t stream);

  // Runs the steps one by one.
  void runTimed(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
  // What they took, once the stream has been waited for.
  StageTimes times() const;

 private:
  // Beside the stream itself.
  static constexpr int kBranches = 3;
  static constexpr int kSteps = 12;

  // What came last, bit by bit: arrays that moved, or count otherwise, are others.
  bool isLast(const CycleArrays& cycle, const CycleShape& shape) const;
  void record(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);
  bool update(cudaGraph_t recorded) const;
  void forget();
  // The steps, on `stream` and the branches.
  void enqueue(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream);

  CycleShape shape_;
  std::vector<unsigned char> arrays_;  // the bytes of the last cycle's
  bool is_recorded_ = false;           // the last cycle, in graph_
  cudaGraphExec_t graph_ = nullptr;
  CycleShape graph_shape_;
  std::size_t graph_nodes_ = 0;
  CudaStream branch_[kBranches];
  CudaEvent started_, done_[kSteps];  // done_: of each step
  CudaEvent mark_[kSteps + 1];        // before each step of a timed run, and behind the last
};

}  // namespace deformable_contact_monitor
