// Makes one detector out of several: each works on one partition of the scene, on its own device.
#pragma once

#include <functional>
#include <memory>

#include "core/detector.h"
#include "cuda/cuda_detector.h"
#include "cuda/partitions/scene_partition.h"

namespace deformable_contact_monitor {

// A detector that can be restricted to one partition of the scene.
class PartitionDetector : public Detector {
 public:
  // Restricts detection to the pairs of the partition, from the next detect() on; at first the
  // whole scene is detected. The partition may change from cycle to cycle; a large move costs time,
  // as a large move of the scene does.
  virtual void setPartition(const ScenePartition& partition) = 0;
};

// Makes a CUDA detector on settings.device alone. The contract is that of makeCudaDetector().
std::unique_ptr<PartitionDetector> makeCudaPartitionDetector(const CudaSettings& settings);

// Makes a detector that works on all of settings.devices. `make` is called once for each device,
// with settings that name this device only. If only one call succeeds, its detector is returned as
// it is. Devices whose call throws are reported to settings.device_lost; if no call succeeds, the
// last exception is rethrown. detect() throws if all devices have failed. The rest of the contract
// is that of makeCudaDetector().
std::unique_ptr<Detector> makePartitionedDetector(
    const CudaSettings& settings,
    const std::function<std::unique_ptr<PartitionDetector>(const CudaSettings&)>& make);

}  // namespace deformable_contact_monitor
