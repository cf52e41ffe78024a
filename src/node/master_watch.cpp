// Asks the ROS master for topics, and whether it still knows this node.
#include "node/master_watch.h"

#include <netdb.h>
#include <poll.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <sys/socket.h>
#include <unistd.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <cerrno>
#include <cstdint>
#include <memory>
#include <optional>

namespace deformable_contact_monitor {
namespace {

using XmlRpc::XmlRpcValue;

// Returns the answer, or nothing if there is none. ros::master::getTopics() would wait for one,
// even after a shutdown.
std::optional<XmlRpcValue> ask(const std::string& method,
                               const std::optional<std::string>& argument = std::nullopt) {
  XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  if (argument) request[1] = *argument;
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

enum Role { kPublisher = 0, kSubscriber = 1 };

// Returns whether the node has that role on the topic. `state` is what getSystemState() returns:
// lists of publishers, subscribers and services; each entry is a topic and a list of nodes.
bool isListed(XmlRpcValue& state, Role role, const std::string& topic, const std::string& node) {
  XmlRpcValue& topics = state[role];
  for (int i = 0; i < topics.size(); ++i) {
    if (static_cast<std::string&>(topics[i][0]) == topic) return contains(topics[i][1], node);
  }
  return false;
}

// Returns false only if the connection is refused. A host that does not answer counts as listening.
bool mayListen(const addrinfo& address) {
  constexpr int kPatienceMs = 300;
  const int socket = ::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) return errno != EAFNOSUPPORT;  // a kernel without IPv6
  int error = connect(socket, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  pollfd one{socket, POLLOUT, 0};
  if (error == EINPROGRESS && poll(&one, 1, kPatienceMs) == 1) {
    socklen_t size = sizeof error;
    getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  }
  close(socket);
  return error != ECONNREFUSED && error != EADDRNOTAVAIL;
}

// Does the same for each address of the node's host. Returns true if one may listen.
bool mayListen(const std::string& uri) {
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(uri, host, port)) return true;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), nullptr, &found) != 0) return true;
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, &freeaddrinfo);
  for (; found != nullptr; found = found->ai_next) {
    if (found->ai_socktype == SOCK_STREAM && mayListen(*found)) return true;
  }
  return false;
}

}  // namespace

std::map<std::string, std::string> publishedTypes() {
  std::map<std::string, std::string> types;
  std::optional<XmlRpcValue> topics = ask("getPublishedTopics", "");
  for (int i = 0; topics && i < topics->size(); ++i) {
    types[static_cast<std::string&>((*topics)[i][0])] = static_cast<std::string&>((*topics)[i][1]);
  }
  return types;
}

bool mayPublish(const std::string& node, const std::string& topic) {
  std::optional<XmlRpcValue> state = ask("getSystemState");
  // A restarted master does not list this node either, so its answer proves nothing.
  if (!state || !isListed(*state, kSubscriber, topic, ros::this_node::getName())) return true;
  if (!isListed(*state, kPublisher, topic, node)) return false;
  std::optional<XmlRpcValue> uri = ask("lookupNode", node);
  return !uri || mayListen(static_cast<std::string&>(*uri));
}

bool MasterWatch::isUnregistered() {
  constexpr int kSure = 2;  // one answer may come while the node registers
  std::optional<XmlRpcValue> state = ask("getSystemState");
  if (!state) return false;
  if (isListed(*state, kPublisher, topic_, ros::this_node::getName())) {
    was_known_ = true;
    unknown_in_a_row_ = 0;
    return false;
  }
  return was_known_ && ++unknown_in_a_row_ >= kSure;
}

}  // namespace deformable_contact_monitor
