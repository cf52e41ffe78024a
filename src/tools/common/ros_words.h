// Separates a node's own command line from what ROS reads of it.
#pragma once

#include <ros/init.h>

#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Returns the words of a command line that ROS does not read: all but the program's name and
// remappings such as `a:=b` and `__name:=b`. It needs no ros::init(), so a node can answer --help
// before it starts.
inline std::vector<std::string> wordsForNode(int argc, const char* const* argv) {
  std::vector<std::string> words;
  ros::removeROSArgs(argc, argv, words);
  if (!words.empty()) words.erase(words.begin());
  return words;
}

}  // namespace deformable_contact_monitor
