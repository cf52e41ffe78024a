// The options that say what an evaluation of bags reads: files, and topics of the bags.
//
// Builds without ROS use this header too: the command line of measure_trade is the same there.
#pragma once

#include <string>
#include <vector>

#include "tools/common/command_line.h"

namespace deformable_contact_monitor {

// Empty texts and lists stand for options that are not given.
struct BagFiles {
  std::vector<std::string> bags;
  std::string config;             // the node's parameters (yaml); empty: defaults
  std::string robot_description;  // URDF or rosparam dump; empty: from the bags
  std::string srdf;               // SRDF of the robot; empty: as the configuration says
  std::string reference_frame;    // empty: as the configuration says
  std::string frame_prefix;       // empty: as the configuration says

  // Topics to read in place of the usual ones.
  std::vector<std::string> tf_topics;  // for /tf; each stands for TOPIC and TOPIC_static
  std::string joint_states;            // for /joint_states
  std::string robot_description_topic;
  std::string robot_meshes_topic;
  std::vector<std::string> objects;  // OBJECT=TOPIC
};

// Adds the options of everything but `bags`. If `required` names an option, such as --bag, the
// others are errors without it.
void describe(CommandLine* line, BagFiles* files, const std::string& required = "");

}  // namespace deformable_contact_monitor
