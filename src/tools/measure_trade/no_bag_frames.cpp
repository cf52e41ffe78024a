// Stands in for the bag reader in builds without it.
#include <stdexcept>

#include "tools/measure_trade/bag_frames.h"

namespace deformable_contact_monitor {

std::unique_ptr<FrameSource> makeBagFrames(
    const BagFiles& files, const std::function<void(const std::string&)>& /*progress*/,
    const std::function<void(const std::string&)>& /*warn*/) {
  throw std::runtime_error(files.bags.front() +
                           ": this build reads no bags: it was made without ROS");
}

}  // namespace deformable_contact_monitor
