// Asks the ROS master for topics, and whether it still knows this node.
#include "node/master_watch.h"

#include <ros/master.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <optional>

namespace deformable_contact_monitor {
namespace {

using XmlRpc::XmlRpcValue;

// Returns the answer, or nothing if there is none. ros::master::getTopics() would wait for one,
// even after a shutdown.
std::optional<XmlRpcValue> ask(const std::string& method, const std::string& argument = "") {
  XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  if (method == "getPublishedTopics") request[1] = argument;
  if (!ros::master::execute(method, request, response, payload, false)) return std::nullopt;
  return payload;
}

// XmlRpcValue has no const access, hence the references here and below.
bool contains(XmlRpcValue& names, const std::string& name) {
  for (int i = 0; i < names.size(); ++i) {
    if (static_cast<std::string&>(names[i]) == name) return true;
  }
  return false;
}

// Returns whether the node publishes on the topic. `state` is what getSystemState() returns: lists
// of publishers, subscribers and services; each entry is a topic and a list of nodes.
bool isPublisher(XmlRpcValue& state, const std::string& topic, const std::string& node) {
  XmlRpcValue& publishers = state[0];
  for (int i = 0; i < publishers.size(); ++i) {
    if (static_cast<std::string&>(publishers[i][0]) == topic) {
      return contains(publishers[i][1], node);
    }
  }
  return false;
}

}  // namespace

std::map<std::string, std::string> publishedTypes() {
  std::map<std::string, std::string> types;
  std::optional<XmlRpcValue> topics = ask("getPublishedTopics");
  for (int i = 0; topics && i < topics->size(); ++i) {
    types[static_cast<std::string&>((*topics)[i][0])] = static_cast<std::string&>((*topics)[i][1]);
  }
  return types;
}

bool MasterWatch::isUnregistered() {
  constexpr int kSure = 2;  // one answer may come while the node registers
  std::optional<XmlRpcValue> state = ask("getSystemState");
  if (!state) return false;
  if (isPublisher(*state, topic_, ros::this_node::getName())) {
    was_known_ = true;
    unknown_in_a_row_ = 0;
    return false;
  }
  return was_known_ && ++unknown_in_a_row_ >= kSure;
}

}  // namespace deformable_contact_monitor
