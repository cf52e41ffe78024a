// Messages of bags, read so that a damaged bag costs only itself.
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

struct BagMessage {
  std::string topic, type, md5;
  ros::Time received;
  std::vector<std::uint8_t> bytes;  // as serialized; nothing about them has been checked
};

// Which messages of a bag are read: all of some types, and of some topics those of one type each.
struct BagSelection {
  std::set<std::string> types;
  std::map<std::string, std::string> types_of_topics;

  bool has(const std::string& topic, const std::string& type) const;
};

// rosbag's library takes sizes and offsets in a bag on trust: a damaged one makes it read beyond
// its buffers or ask for any amount of memory. So it runs in a process of its own, which hands the
// messages over a pipe, and whose end is the end of the bag. One thread at a time.
class BagReader {
 public:
  // Only messages of the selection are read. Forks: to be called before CUDA or a detector's
  // threads are in use.
  BagReader(std::vector<std::string> paths, BagSelection selection);
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;
  ~BagReader();

  // Hands every message of all the bags to `visit`, in order of receipt; may be called again.
  // Returns why it stopped before the end, for people; empty: it did not. Throws
  // std::runtime_error, one line that names the bag, if one cannot be opened at all: no bag, no
  // index (with the command that mends it), damaged from the start. What `visit` throws comes
  // through, and ends the reading for good.
  std::string read(const std::function<void(const BagMessage&)>& visit);

 private:
  bool receive(void* data, std::size_t size);
  std::string receiveText(std::size_t size);
  [[noreturn]] void serve();

  std::vector<std::string> paths_;
  BagSelection selection_;
  pid_t process_ = -1;
  int requests_ = -1, messages_ = -1;  // pipes' ends of this process
  bool gone_ = false;                  // the process ended, or must not be asked again
};

}  // namespace deformable_contact_monitor
