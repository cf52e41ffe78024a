// Reads parameters from a yaml file, as rosparam would load them into a parameter server.
//
// The tools read the node's configuration files with it, but need no ROS master.
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

namespace deformable_contact_monitor {

// Reads numbers, booleans, texts, lists and maps; null becomes an empty text. Throws
// std::runtime_error, "<path>: <what>, line N", if the file cannot be read or is not valid yaml.
XmlRpc::XmlRpcValue readYamlParameters(const std::string& path);

// Reads a URDF from a file that holds it as it is, or from a rosparam dump of it: a text, or a map
// with the text `robot_description`. Throws std::runtime_error that names the file.
std::string readRobotDescription(const std::string& path);

}  // namespace deformable_contact_monitor
