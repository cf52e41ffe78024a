// Asks the ROS master for topics, and whether it still knows this node.
//
// The master is a process of its own, which is asked over XML-RPC. Nothing here waits for a master
// that is away. An answer that cannot be read throws XmlRpc::XmlRpcException.
#pragma once

#include <map>
#include <string>
#include <utility>

namespace deformable_contact_monitor {

// Returns the type of each topic that has publishers; empty if the master is away. May be called by
// any thread, and may take a while.
std::map<std::string, std::string> publishedTypes();

// Returns whether the node may still publish on the topic. It does not if the master knows no such
// publisher, or nobody listens at the node's address: a killed node stays on the master's list.
// This node must subscribe to the topic. May be called by any thread, and may take a while.
bool mayPublish(const std::string& node, const std::string& topic);

// Finds out whether the master still knows this node. A restarted master knows nobody: new
// subscribers do not find the node, the node does not find new publishers, and roscpp cannot
// register a node again. Not safe for use by several threads.
class MasterWatch {
 public:
  // Takes the resolved name of a topic that this node advertises.
  explicit MasterWatch(std::string topic) : topic_(std::move(topic)) {}

  // Asks the master. Returns true if the master knew this node as a publisher of the topic before,
  // and has answered twice in a row that it does not.
  bool isUnregistered();

 private:
  const std::string topic_;
  bool was_known_ = false;
  int unknown_in_a_row_ = 0;
};

}  // namespace deformable_contact_monitor
