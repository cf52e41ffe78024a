// The files that an evaluation reads. Builds without ROS use this header too: the command line of
// measure_trade is the same there.
#pragma once

#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Empty texts stand for files that are not given.
struct BagFiles {
  std::vector<std::string> bags;
  std::string config;             // the node's parameters (yaml); empty: defaults
  std::string robot_description;  // URDF or rosparam dump; empty: from the bags
  std::string srdf;               // SRDF of the robot; empty: as the configuration says
  std::string reference_frame;    // empty: as the configuration says
};

}  // namespace deformable_contact_monitor
