// One detector of several: each has a share of the scene on a device of its own.
#pragma once

#include <functional>
#include <memory>

#include "cuda/partitions/partition_detector.h"

namespace deformable_contact_monitor {

// `make` gets the settings with one device each, in the order of settings.devices; where there is
// but one, what it makes is the detector. As makeCudaDetector() otherwise: throws what the last one
// threw if none can be made, and detect() does if all have failed.
std::unique_ptr<Detector> makeSharedDetector(
    const CudaSettings& settings,
    const std::function<std::unique_ptr<ShareDetector>(const CudaSettings&)>& make);

}  // namespace deformable_contact_monitor
