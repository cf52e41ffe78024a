// Which recordings are read, and what goes with them.
#pragma once

#include <string>
#include <vector>

namespace deformable_contact_monitor {

struct BagFiles {
  std::vector<std::string> bags;
  std::string config;             // the node's parameters, yaml; empty: defaults
  std::string robot_description;  // URDF or rosparam dump; empty: from the bags
  std::string srdf;               // of the robot's links; empty: the configuration's
  std::string reference_frame;    // empty: the configuration's
};

}  // namespace deformable_contact_monitor
