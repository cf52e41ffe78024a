// What the ROS master says, asked without waiting for it.
#include "node/master_watch.h"

#include <ros/master.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <optional>

namespace deformable_contact_monitor {
namespace {

using XmlRpc::XmlRpcValue;

// Nothing if there is no answer. ros::master::getTopics() would wait for one, beyond shutdown.
std::optional<XmlRpcValue> ask(const std::string& method, const std::string& argument = "") {
  XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  if (method == "getPublishedTopics") request[1] = argument;
  if (!ros::master::execute(method, request, response, payload, false)) return std::nullopt;
  return payload;
}

bool contains(XmlRpcValue& names, const std::string& name) {
  for (int i = 0; i < names.size(); ++i) {
    if (static_cast<std::string&>(names[i]) == name) return true;
  }
  return false;
}

// In the state that the master hands out: lists of publishers, subscribers, services, by topic.
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

bool MasterWatch::isForgotten() {
  constexpr int kSure = 2;
  std::optional<XmlRpcValue> state = ask("getSystemState");
  if (!state) return false;
  if (isPublisher(*state, topic_, ros::this_node::getName())) {
    was_known_ = true;
    looks_unknown_ = 0;
    return false;
  }
  return was_known_ && ++looks_unknown_ >= kSure;
}

}  // namespace deformable_contact_monitor
