// The frames of recorded bags.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tools/bags/bag_files.h"
#include "tools/measure_trade/frame_source.h"

namespace deformable_contact_monitor {

// One frame for each cycle that evaluate_bag would evaluate, its pairs as configured. Keeps the
// deforming vertices of all of them. `progress` is told what the reading is at, `warn` what a user
// should know. Throws std::runtime_error, one line, if a bag cannot be read whole, or in a build
// that reads none.
std::unique_ptr<FrameSource> makeBagFrames(const BagFiles& files,
                                           const std::function<void(const std::string&)>& progress,
                                           const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
