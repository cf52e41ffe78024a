// Trees of ROS parameters, and how the tests of parameters have them read.
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>
#include <vector>

#include "monitor/rules/parameters.h"
#include "refusal.h"

namespace deformable_contact_monitor {

using XmlRpc::XmlRpcValue;

template <typename... T>
XmlRpcValue list(const T&... items) {
  XmlRpcValue value;
  value.setSize(sizeof...(items));
  int i = 0;
  ((value[i++] = XmlRpcValue(items)), ...);
  return value;
}

inline XmlRpcValue object(const std::string& name) {
  XmlRpcValue value;
  value["name"] = name;
  return value;
}

inline MonitorParameters parse(const XmlRpcValue& tree,
                               std::vector<std::string>* warnings = nullptr) {
  std::vector<std::string> unused;
  return parseParameters(tree, warnings == nullptr ? &unused : warnings);
}

inline std::string refusalOf(const XmlRpcValue& tree) {
  return refusal<ParameterError>([&tree] { parse(tree); });
}

}  // namespace deformable_contact_monitor
