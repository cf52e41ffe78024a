// Runs the stages of a cycle on the device, and repeats them until all results have room.
#pragma once

#include "core/common/cycle_limit.h"
#include "core/common/stages.h"
#include "core/options.h"
#include "cuda/cycle/contact_collector.cuh"
#include "cuda/cycle/cycle_graph.cuh"
#include "cuda/cycle/device_cycle.cuh"

namespace deformable_contact_monitor {

// Belongs to one detector. Uses recorded graphs where it can (cycle_graph.cuh).
class CycleRunner {
 public:
  CycleRunner(DeviceCycle& cycle, ContactCollector& collector)
      : cycle_(cycle), collector_(collector) {}

  // Runs cycles until one fits into the arrays, which grow in between, and fetches the contacts. If
  // the candidates do not fit into the memory limit, the last cycle is continued in passes. Returns
  // false if the limit was over before all pairs were examined; the contacts are then those that
  // the last cycle found. Throws CudaError.
  bool run(const Options& options, const CycleLimit& limit);

  // Waits for what run() has begun beside the cycle's stream, also if it threw.
  void waitForBranches() {
    for (CycleGraph& graph : graphs_) graph.waitForBranches();
  }

  // Returns how long the device worked in the last run() [ms], including tries that did not fit.
  double deviceMs() const { return earlier_ms_ + CudaEvent::between(cycle_start_, cycle_end_); }
  // Returns the times of the stages in the last run() [ms], with CudaSettings::time_stages.
  StageTimes stageTimes() const { return graphs_[0].times(); }

 private:
  void runOnce(const Options& options);
  bool isCutOff(const CycleLimit& limit) const;
  bool makeRoom();
  bool runInPasses(const Options& options, const CycleLimit& limit);
  bool sweepInPasses(const Options& options, const CycleLimit& limit);
  bool runPass(const CycleShape& shape, std::uint32_t pass, std::uint32_t passes,
               const CycleLimit& limit);

  DeviceCycle& cycle_;
  ContactCollector& collector_;
  CycleGraph graphs_[2];  // without and with refinement of the prototypes
  CudaEvent cycle_start_, cycle_end_;
  double earlier_ms_ = 0;  // device time of this run's tries that did not fit
};

}  // namespace deformable_contact_monitor
