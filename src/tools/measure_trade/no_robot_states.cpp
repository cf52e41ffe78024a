// Stands in for robot_states.cpp in a build without ROS, which cannot read robots.
#include <stdexcept>

#include "tools/measure_trade/robot_states.h"

namespace deformable_contact_monitor {

SceneStates makeRobotStates(const RobotStateFiles& /*files*/, std::size_t /*count*/,
                            std::uint32_t /*seed*/) {
  throw std::runtime_error("--states reads a robot, which a build without ROS cannot do");
}

}  // namespace deformable_contact_monitor
