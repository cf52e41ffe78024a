// Stands in for the bag reader in builds without it.
#include <stdexcept>

#include "tools/bag_frames.h"

namespace deformable_contact_monitor {

std::unique_ptr<FrameSource> makeBagFrames(
    const std::string& bag, const std::function<void(const std::string&)>& /*progress*/) {
  throw std::runtime_error(bag + ": this build reads no bags");
}

}  // namespace deformable_contact_monitor
