// A detector that does not fail while another backend is left.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/detector.h"

namespace deformable_contact_monitor {

using MakeDetector = std::function<std::unique_ptr<Detector>()>;

// Runs what `first` makes; once that fails to be made or to detect, with a std::runtime_error,
// calls warn(why), one line, and from then on, that cycle included, runs what `second` makes.
// backend() is the one that runs.
std::unique_ptr<Detector> makeFallbackDetector(const MakeDetector& first, MakeDetector second,
                                               std::function<void(const std::string&)> warn);

}  // namespace deformable_contact_monitor
