// Reads the messages of bags in a child process, so that a damaged bag cannot crash this one.
//
// This file knows nothing about the messages' contents: bag_messages.h decodes them.
#pragma once

#include <ros/time.h>
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Returns a topic's name with one leading slash and no other superfluous ones. Names that were
// recorded without a leading slash mean the same topics as those with one.
std::string absoluteTopic(const std::string& name);

// A recorded message, still serialized. Its topic is an absoluteTopic().
struct BagMessage {
  std::string topic, type, md5;
  ros::Time received;               // never earlier than that of the message before it
  std::vector<std::uint8_t> bytes;  // as serialized, and not checked yet
  ros::Time clock{};                // what the recorder's clock was, which may have gone back
  std::string publisher{};          // the node's name; empty: the bag does not tell
};

// Selects the messages that are read: all messages of some types, and on some topics the messages
// of one type. Topics are absolute.
struct BagSelection {
  std::set<std::string> types;
  std::map<std::string, std::string> types_of_topics;

  bool has(const std::string& topic, const std::string& type) const;
};

// Reads bags with rosbag's library. The library trusts sizes and offsets in a bag, so a damaged bag
// makes it read beyond its buffers or allocate any amount of memory. Therefore it runs in a child
// process, which sends the messages through a pipe. If the child crashes, the bag ends there. Use
// it from one thread at a time.
class BagReader {
 public:
  // Reads only messages of the selection. The constructor forks, so call it before CUDA or a
  // detector's threads are in use.
  BagReader(std::vector<std::string> paths, BagSelection selection);
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;
  ~BagReader();

  // Calls visit(message) for every message of all bags, in order of receipt. Where the recorder's
  // clock went back, a single bag is read in the order of its file, and its times of receipt go on
  // from where they were; several bags are refused. It may be called
  // again. Returns why it stopped before the end, for people; empty: it did not. Throws
  // std::runtime_error, one line that names the bag, if a bag cannot be opened: it is not a bag,
  // has no index (the text names the command that mends it), is damaged at its start, or is given
  // twice. An exception of `visit` passes through, and the reader cannot be used after it.
  std::string read(const std::function<void(const BagMessage&)>& visit);

  // Returns the types of all topics with messages, whether they are selected or not. They are known
  // when read() visits its first message, and afterwards.
  const std::map<std::string, std::string>& topics() const { return topics_; }

 private:
  bool receive(void* data, std::size_t size, int patience_ms);
  std::string receiveText(std::size_t size);
  [[noreturn]] void serve();

  std::vector<std::string> paths_;
  BagSelection selection_;
  std::map<std::string, std::string> topics_;
  pid_t process_ = -1;
  int requests_ = -1, messages_ = -1;  // this process's ends of the pipes
  bool gone_ = false;                  // the child ended, or must not be asked again
  int opening_ms_ = 0;                 // how long the child may be silent at first
};

}  // namespace deformable_contact_monitor
