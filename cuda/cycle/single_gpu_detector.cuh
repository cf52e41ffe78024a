// Implements the detector on one GPU: uploads a scene, runs the stages, and collects the contacts.
#pragma once

#include <string>

#include "core/common/cycle_limit.h"
#include "core/common/stopwatch.h"
#include "cuda/cuda_detector.h"
#include "cuda/cycle/contact_collector.cuh"
#include "cuda/cycle/cycle_runner.cuh"
#include "cuda/cycle/cycle_upload.cuh"
#include "cuda/cycle/device_cycle.cuh"
#include "cuda/partitions/partitioned_detector.h"

namespace deformable_contact_monitor {

// Implements the contract of makeCudaDetector() on settings.device, which must be usable. For one
// thread at a time. The order of the members matters: each part uses those before it.
class SingleGpuDetector : public PartitionDetector {
 public:
  explicit SingleGpuDetector(const CudaSettings& settings);
  ~SingleGpuDetector() override;

  std::string backend() const override { return "cuda"; }
  void reset() override { upload_.reset(); }
  void swapResult(DetectionResult& result) override { result_.swap(result); }
  std::pmr::memory_resource& vertexMemory() override;
  void setPartition(const ScenePartition& partition) override { upload_.setPartition(partition); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  void findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                    const Stopwatch& watch);
  void addTimes(double upload_ms, double output_ms, bool swept);

  DetectionResult result_;
  DeviceCycle cycle_;
  CycleUpload upload_{cycle_};
  ContactCollector collector_{cycle_, result_};
  CycleRunner runner_{cycle_, collector_};
};

}  // namespace deformable_contact_monitor
