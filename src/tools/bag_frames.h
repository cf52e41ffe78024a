// The frames of a recorded bag.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tools/frame_source.h"

namespace deformable_contact_monitor {

// `progress` is told what the reading is at. Throws std::runtime_error, one line, if the bag cannot
// be read, or in a build that reads none.
std::unique_ptr<FrameSource> makeBagFrames(const std::string& bag,
                                           const std::function<void(const std::string&)>& progress);

}  // namespace deformable_contact_monitor
