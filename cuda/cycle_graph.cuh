// The stages of a cycle in order: as a CUDA graph, or one after the other with their times.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cuda/device/launch.cuh"
#include "cuda/memory/cycle_view.cuh"
#include "cuda/memory/device_buffer.cuh"

namespace deformable_contact_monitor {

// What a cycle consists of; with the view, all that a recorded graph depends on.
struct CycleShape {
  DeviceTraits device;
  bool identify = false;  // some body has self contact
  int refinements = 0;    // of the prototypes, for the next cycle

  bool operator==(const CycleShape& o) const {
    return device == o.device && identify == o.identify && refinements == o.refinements;
  }
};

// One recorded cycle and the streams of its branches. A view must stay valid while it is in use.
class CycleGraph {
 public:
  CycleGraph() = default;
  CycleGraph(const CycleGraph&) = delete;
  CycleGraph& operator=(const CycleGraph&) = delete;
  ~CycleGraph() { forget(); }

  // Records the cycle if it is not the one recorded last.
  void prepare(const CycleView& cycle, const CycleShape& shape, cudaStream_t stream);
  void launch(cudaStream_t stream);
  // To be called when views change.
  void forget();

  // Runs the stages one by one; their times [ms] by name, once the stream has been waited for.
  void runTimed(const CycleView& cycle, const CycleShape& shape, cudaStream_t stream);
  std::vector<std::pair<std::string, double>> times() const;

 private:
  // The cycle, on `stream` and the branches.
  void enqueue(const CycleView& cycle, const CycleShape& shape, cudaStream_t stream);

  CycleShape shape_;
  cudaGraphExec_t graph_ = nullptr;
  CudaStream identity_branch_, large_branch_, adapt_branch_;
  CudaEvent started_, identified_, assigned_, sized_, sorted_, large_done_, adapted_;
  static constexpr int kStages = 8;
  CudaEvent mark_[kStages + 1];
};

}  // namespace deformable_contact_monitor
