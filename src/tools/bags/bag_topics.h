// Chooses the topics of bags from which transforms, joint states and the robot are read.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "tools/common/bag_files.h"

namespace deformable_contact_monitor {

// The types of recorded topics, by their absolute names.
using RecordedTopics = std::map<std::string, std::string>;

// The chosen topics. A text is empty if the bags have no such topic.
struct BagTopics {
  std::set<std::string> transforms;  // moving and static ones; some may not be recorded
  std::string joint_states;          // may not be recorded
  std::string link_meshes;
  // Those of each robot, in the order of MonitorParameters::allRobots().
  struct Robot {
    std::string description, semantic;
  };
  std::vector<Robot> robots;

  // Say which topics were recorded but are not read, and by which option they would be. Empty:
  // there are none. They are worth a warning only if a link's frame is missing; transforms always
  // are.
  std::string other_transforms, other_joint_states;
};

// Chooses the topics. Those of robots are chosen only if one is needed. Robots of the parameter
// `robots` have the topics with the names of their descriptions. Throws std::runtime_error, one
// line that names the bags, the topics and the option, if there are several robots to choose from,
// or if nothing of its kind was recorded on a topic that an option names.
BagTopics chooseTopics(const RecordedTopics& recorded, const BagFiles& files,
                       const MonitorParameters& parameters);

// Returns the topic of joint states that the options choose.
std::string jointStatesTopic(const BagFiles& files);

// Returns the topics of the option --topic by object. Throws std::runtime_error, one line, if a
// value is not OBJECT=TOPIC, or an object or a topic is there twice.
std::map<std::string, std::string> objectTopics(const BagFiles& files);

// Returns true if transforms on this topic are static.
bool isStatic(const std::string& topic);

// Returns the absolute topic of an object, for a monitor whose name is /contact_monitor.
std::string topicOf(const ObjectParameters& object);

}  // namespace deformable_contact_monitor
