// What the ROS master says, asked without waiting for it to come back. An answer that is none
// throws XmlRpc::XmlRpcException.
#pragma once

#include <map>
#include <string>
#include <utility>

namespace deformable_contact_monitor {

// The types of the topics that somebody publishes on, by topic; empty if the master is away. Any
// thread, but it may take a while.
std::map<std::string, std::string> publishedTypes();

// Whether the master still knows this node. A master that was started anew knows nobody: no new
// subscriber finds the node then, nor does the node find new publishers, and roscpp cannot register
// a node again. One thread at a time.
class MasterWatch {
 public:
  // `topic`: one that this node advertises, resolved.
  explicit MasterWatch(std::string topic) : topic_(std::move(topic)) {}

  // Asks the master; whether it has been there for two looks in a row without knowing that this
  // node, which it knew, publishes on the topic.
  bool isForgotten();

 private:
  const std::string topic_;
  bool was_known_ = false;
  int looks_unknown_ = 0;
};

}  // namespace deformable_contact_monitor
