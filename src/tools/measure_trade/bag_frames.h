// The frames of recorded bags.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/measure_trade/frame_source.h"

namespace deformable_contact_monitor {

// As evaluate_bag takes them.
struct BagFrameFiles {
  std::vector<std::string> bags;
  std::string config, robot_description, reference_frame;  // empty: as evaluate_bag does then
};

// One frame for each cycle that evaluate_bag would evaluate, its pairs as configured. Keeps the
// deforming vertices of all of them. `progress` is told what the reading is at, `warn` what a user
// should know. Throws std::runtime_error, one line, if a bag cannot be read whole, or in a build
// that reads none.
std::unique_ptr<FrameSource> makeBagFrames(const BagFrameFiles& files,
                                           const std::function<void(const std::string&)>& progress,
                                           const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
