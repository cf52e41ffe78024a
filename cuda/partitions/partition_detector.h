// A detector of one device of several.
#pragma once

#include <memory>

#include "core/detector.h"
#include "cuda/cuda_detector.h"
#include "cuda/partitions/scene_partition.h"

namespace deformable_contact_monitor {

class ShareDetector : public Detector {
 public:
  // From the next detect() on, the pairs of the share alone are looked for; the whole at first. The
  // share may change from cycle to cycle: far moves cost time, as those of a scene do.
  virtual void setShare(const SceneShare& share) = 0;
};

// As makeCudaDetector(), on settings.device alone.
std::unique_ptr<ShareDetector> makeCudaShareDetector(const CudaSettings& settings);

}  // namespace deformable_contact_monitor
