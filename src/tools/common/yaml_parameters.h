// Parameters from a yaml file, as rosparam would load it into a parameter server.
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

namespace deformable_contact_monitor {

// Numbers, booleans, texts, lists and maps; null reads as an empty text. Throws std::runtime_error,
// "<path>: <what>, line N", if the file cannot be read, is no yaml or holds something else.
XmlRpc::XmlRpcValue readYamlParameters(const std::string& path);

// A URDF from a file that holds it as it is, or from a rosparam dump of it: a text, or the text
// `robot_description` of a map. Throws std::runtime_error that names the file.
std::string readRobotDescription(const std::string& path);

}  // namespace deformable_contact_monitor
