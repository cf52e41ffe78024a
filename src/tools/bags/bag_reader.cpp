// Reads bags in a child process. The child gets one byte for each request, and answers with the
// messages of all bags, each a Header, its texts and its bytes.
#include "tools/bags/bag_reader.h"

#include <fcntl.h>
#include <poll.h>
#include <ros/names.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "tools/bags/bag_messages.h"
#include "tools/bags/bag_records.h"
#include "tools/bags/recorded_order.h"

namespace deformable_contact_monitor {
namespace {

// The child counts as crashed if it sends no byte for so long. Before its first byte, it opens all
// bags, which takes some seeks for each chunk of some 0.8 MB.
constexpr int kPatienceMs = 60000;
constexpr std::uintmax_t kBytesPerMs = 50000;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr rlim_t kMemory = RLIM_INFINITY;  // sanitizers reserve terabytes of addresses
#else
constexpr rlim_t kMemory = rlim_t{16} << 30;  // limit of the child's address space [bytes]
#endif
constexpr std::uint32_t kLongest = 0xC0000000;  // longest message [bytes]

// Precedes the texts and bytes of each answer in the pipe.
struct Header {
  enum Kind : std::uint32_t { kTopic, kMessage, kEnd, kCannotOpen };
  std::uint32_t kind = kEnd;
  // Lengths. kTopic has a topic and a type; kEnd and kCannotOpen have only bytes.
  std::uint32_t topic = 0, type = 0, md5 = 0, publisher = 0, bytes = 0;
  std::uint32_t sec = 0, nsec = 0;              // BagMessage::received
  std::uint32_t clock_sec = 0, clock_nsec = 0;  // BagMessage::clock
};

// Writes everything to the pipe, or ends the child if the parent is gone.
void send(int pipe, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t sent = write(pipe, at, size);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) _exit(0);  // the parent is gone
    at += sent;
    size -= static_cast<std::size_t>(sent);
  }
}

// Answers a request's end, with a text that says why: empty if nothing is wrong.
void sendText(int pipe, Header::Kind kind, const std::string& text) {
  Header header;
  header.kind = kind;
  header.bytes = static_cast<std::uint32_t>(text.size());
  send(pipe, &header, sizeof header);
  send(pipe, text.data(), text.size());
}

// Sends the names and types of the bag's topics with messages.
void sendTopics(int pipe, const rosbag::Bag& bag) {
  rosbag::View all(bag);
  for (const rosbag::ConnectionInfo* const connection : all.getConnections()) {
    Header header;
    header.kind = Header::kTopic;
    header.topic = static_cast<std::uint32_t>(connection->topic.size());
    header.type = static_cast<std::uint32_t>(connection->datatype.size());
    send(pipe, &header, sizeof header);
    send(pipe, (connection->topic + connection->datatype).data(), header.topic + header.type);
  }
}

// The stream that MessageInstance::write writes to. It checks the length that the bag claims.
struct ByteStream {
  std::vector<std::uint8_t>* bytes;
  std::size_t at = 0;

  std::uint8_t* advance(std::uint32_t size) {
    if (size > bytes->size() - at) throw rosbag::BagFormatException("a message is too long");
    std::uint8_t* const start = bytes->data() + at;
    at += size;
    return start;
  }
  std::uint8_t* getData() { return bytes->data() + at; }
  std::uint32_t getLength() const { return static_cast<std::uint32_t>(bytes->size() - at); }
};

BagMessage bytesOf(const rosbag::MessageInstance& message, const ros::Time& received) {
  BagMessage bytes{message.getTopic(),
                   message.getDataType(),
                   message.getMD5Sum(),
                   received,
                   std::vector<std::uint8_t>(message.size()),
                   message.getTime(),
                   message.getCallerId()};
  ByteStream stream{&bytes.bytes};
  message.write(stream);
  return bytes;
}

// Sends one message. The child does not decode it.
void sendMessage(int pipe, const BagMessage& message) {
  Header header;
  header.kind = Header::kMessage;
  header.topic = static_cast<std::uint32_t>(message.topic.size());
  header.type = static_cast<std::uint32_t>(message.type.size());
  header.md5 = static_cast<std::uint32_t>(message.md5.size());
  header.publisher = static_cast<std::uint32_t>(message.publisher.size());
  header.bytes = static_cast<std::uint32_t>(message.bytes.size());
  header.sec = message.received.sec;
  header.nsec = message.received.nsec;
  header.clock_sec = message.clock.sec;
  header.clock_nsec = message.clock.nsec;
  send(pipe, &header, sizeof header);
  const std::string texts = message.topic + message.type + message.md5 + message.publisher;
  send(pipe, texts.data(), texts.size());
  send(pipe, message.bytes.data(), message.bytes.size());
}

// Throws std::runtime_error for files that rosbag would report in a confusing way.
void checkStart(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string start(13, '\0');
  if (!file || std::filesystem::is_directory(path)) throw std::runtime_error("cannot be read");
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  if (start.empty()) throw std::runtime_error("is empty");
  if (start.compare(0, 8, "#ROSBAG ") != 0) throw std::runtime_error("is no bag");
}

// Reports a wrong index like rosbag's own errors, so that openBag() adds how to mend it.
void checkIndex(const std::string& path) {
  try {
    checkBagIndex(path);
  } catch (const std::exception& error) {
    throw rosbag::BagFormatException(error.what());
  }
}

// Opens a bag and checks its index. Errors name the bag and say how to mend it.
void openBag(const std::string& path, rosbag::Bag* bag) {
  const std::string mend = "; mend it with: rosbag reindex " + path;
  try {
    checkStart(path);
    bag->open(path, rosbag::bagmode::Read);
    if (bag->getMajorVersion() == 2) checkIndex(path);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::runtime_error(path + ": has no index, as if its recording was cut off" + mend);
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": damaged or cut off (" + error.what() + ")" + mend);
  } catch (const std::bad_alloc&) {
    throw std::runtime_error(path + ": damaged: it asks for more memory than a bag can need" +
                             mend);
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

// Throws std::runtime_error if two paths lead to one bag: its messages would count twice.
void checkDifferent(const std::vector<std::string>& paths) {
  for (std::size_t i = 0; i < paths.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      std::error_code none;  // openBag() tells what is wrong with a path
      if (!std::filesystem::equivalent(paths[k], paths[i], none)) continue;
      throw std::runtime_error(paths[i] + ": is given twice" +
                               (paths[k] == paths[i] ? "" : ", also as " + paths[k]));
    }
  }
}

// The messages of each connection, by its number, in the order of rosbag's index.
using Connections = std::map<std::uint32_t, std::vector<rosbag::MessageInstance>>;

Connections selectedConnections(const rosbag::Bag& bag, const BagSelection& selection) {
  Connections selected;
  rosbag::View all(bag);
  for (const rosbag::ConnectionInfo* const connection : all.getConnections()) {
    if (!selection.has(connection->topic, connection->datatype)) continue;
    rosbag::View view(bag, [connection](const rosbag::ConnectionInfo* other) {
      return other->id == connection->id;
    });
    for (const rosbag::MessageInstance& message : view) {
      selected[connection->id].push_back(message);
    }
  }
  return selected;
}

// Returns whether the transforms of a connection contradict those of before their times fell. A
// damaged message tells nothing.
bool isOfSeveralEpisodes(const rosbag::Bag& bag, std::uint32_t connection,
                         const std::vector<std::size_t>& parts) {
  rosbag::View view(
      bag, [connection](const rosbag::ConnectionInfo* other) { return other->id == connection; });
  const std::vector<rosbag::MessageInstance> messages(view.begin(), view.end());
  std::vector<std::size_t> ranks(messages.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  std::stable_sort(ranks.begin(), ranks.end(), [&parts](std::size_t a, std::size_t b) {
    return parts.at(a) < parts.at(b);  // by far faster than to read the parts in turn
  });
  EpisodesOfTransforms episodes;
  std::size_t part = 0;
  for (const std::size_t rank : ranks) {
    if (std::exchange(part, parts[rank]) != parts[rank]) episodes.beginPart();
    try {
      const BagMessage message = bytesOf(messages[rank], messages[rank].getTime());
      for (const auto& transform : toTransforms(message).transforms) episodes.add(transform);
    } catch (const std::exception&) {
    }
    if (episodes.found()) return true;
  }
  return false;
}

// Returns the order of the messages if the recorder's clock went back; else nothing. Where there is
// more than transforms, these tell only if they contradict one another: several recordings of them
// may have been merged.
std::vector<OrderedMessage> orderOf(const rosbag::Bag& bag, const BagSelection& selection) {
  std::set<std::uint32_t> all, others;
  rosbag::View view(bag);
  for (const rosbag::ConnectionInfo* const connection : view.getConnections()) {
    const std::string& type = connection->datatype;
    if (!selection.has(connection->topic, type)) continue;
    all.insert(connection->id);
    if (type != "tf2_msgs/TFMessage" && type != "tf/tfMessage") others.insert(connection->id);
  }
  if (bag.getMajorVersion() != 2) return {};
  try {
    return recordedOrder(bag.getFileName(), all, others.empty() ? all : others,
                         [&bag](std::uint32_t connection, const std::vector<std::size_t>& parts) {
                           return isOfSeveralEpisodes(bag, connection, parts);
                         });
  } catch (const std::exception& error) {
    throw std::runtime_error(bag.getFileName() + ": " + error.what());
  }
}

// Sends the messages of a bag whose recorder's clock went back, in the order in which they were
// written. rosbag's own view would mix what was recorded at the same times.
void sendInOrder(int pipe, const rosbag::Bag& bag, const BagSelection& selection,
                 const std::vector<OrderedMessage>& order) {
  const Connections connections = selectedConnections(bag, selection);
  for (const OrderedMessage& message : order) {
    sendMessage(pipe,
                bytesOf(connections.at(message.connection).at(message.rank), message.received));
  }
}

// Answers one request, in the child.
void readAll(int pipe, const std::vector<std::string>& paths, const BagSelection& selection) {
  // A deque does not move its bags, which the view points to.
  std::deque<rosbag::Bag> bags;
  rosbag::View view;
  std::vector<OrderedMessage> order;
  try {
    checkDifferent(paths);
    for (const std::string& path : paths) {
      openBag(path, &bags.emplace_back());
      order = orderOf(bags.back(), selection);
      if (!order.empty() && paths.size() > 1) {
        throw std::runtime_error(path +
                                 ": the recorder's clock went back; evaluate this bag alone");
      }
      view.addQuery(bags.back(), [&selection](const rosbag::ConnectionInfo* connection) {
        return selection.has(connection->topic, connection->datatype);
      });
    }
  } catch (const std::exception& error) {
    return sendText(pipe, Header::kCannotOpen, error.what());
  }
  try {
    for (const rosbag::Bag& bag : bags) sendTopics(pipe, bag);
    if (!order.empty()) {
      sendInOrder(pipe, bags.front(), selection, order);
    } else {
      for (const rosbag::MessageInstance& message : view) {
        sendMessage(pipe, bytesOf(message, message.getTime()));
      }
    }
    sendText(pipe, Header::kEnd, "");
  } catch (const std::bad_alloc&) {
    sendText(pipe, Header::kEnd, "a size in it is senseless");
  } catch (const std::exception& error) {
    sendText(pipe, Header::kEnd, *error.what() == '\0' ? "unreadable" : error.what());
  }
}

}  // namespace

std::string absoluteTopic(const std::string& name) { return ros::names::clean("/" + name); }

bool BagSelection::has(const std::string& topic, const std::string& type) const {
  const auto of_topic = types_of_topics.find(absoluteTopic(topic));
  return types.count(type) > 0 || (of_topic != types_of_topics.end() && of_topic->second == type);
}

// Pipes are closed on exec, so that programs which this process starts do not keep them open.
BagReader::BagReader(std::vector<std::string> paths, BagSelection selection)
    : paths_(std::move(paths)), selection_(std::move(selection)) {
  std::uintmax_t bytes = 0;
  for (const std::string& path : paths_) {
    std::error_code none;  // openBag() tells what is wrong with a path
    const std::uintmax_t size = std::filesystem::file_size(path, none);
    if (!none) bytes += size;
  }
  constexpr std::uintmax_t kMostMs = std::numeric_limits<int>::max();
  opening_ms_ = static_cast<int>(std::min(kPatienceMs + bytes / kBytesPerMs, kMostMs));
  int requests[2], messages[2];
  if (pipe2(requests, O_CLOEXEC) != 0 || pipe2(messages, O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "no pipe to a reader of bags");
  }
  process_ = fork();
  if (process_ < 0) throw std::system_error(errno, std::generic_category(), "no reader of bags");
  if (process_ == 0) {
    requests_ = requests[0];
    messages_ = messages[1];
    close(requests[1]);
    close(messages[0]);
    serve();
  }
  requests_ = requests[1];
  messages_ = messages[0];
  close(requests[0]);
  close(messages[1]);
}

BagReader::~BagReader() {
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  close(requests_);
  close(messages_);
}

// Runs in the child until the parent closes its end of the pipe.
void BagReader::serve() {
  // The child must not outlive a parent that crashes.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  signal(SIGPIPE, SIG_IGN);
  const rlimit no_core{0, 0}, memory{kMemory, kMemory};
  setrlimit(RLIMIT_CORE, &no_core);
  setrlimit(RLIMIT_AS, &memory);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(nowhere, STDERR_FILENO);  // hides the allocator's last message
  char request = 0;
  while (::read(requests_, &request, 1) == 1) readAll(messages_, paths_, selection_);
  _exit(0);
}

// Reads exactly `size` bytes. Returns false if the child is gone or silent for too long.
bool BagReader::receive(void* data, std::size_t size, int patience_ms) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    pollfd waiting{messages_, POLLIN, 0};
    const int ready = poll(&waiting, 1, patience_ms);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t count = ::read(messages_, at, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

std::string BagReader::receiveText(std::size_t size) {
  std::string text(size, '\0');
  if (!receive(text.data(), size, kPatienceMs)) gone_ = true;
  return text;
}

std::string BagReader::read(const std::function<void(const BagMessage&)>& visit) {
  constexpr const char* kCrashed = "rosbag's own reader fails on it";
  const char request = 1;
  if (gone_ || write(requests_, &request, 1) != 1) return kCrashed;
  gone_ = true;  // until an answer is complete
  Header header;
  int patience_ms = opening_ms_;
  while (receive(&header, sizeof header, patience_ms)) {
    gone_ = false;
    patience_ms = kPatienceMs;
    // The child may be damaged by the bag, so its lengths are checked too.
    const std::uint64_t texts =
        std::uint64_t{header.topic} + header.type + header.md5 + header.publisher;
    if (texts + header.bytes > kLongest) break;
    if (header.kind == Header::kTopic) {
      const std::string topic = absoluteTopic(receiveText(header.topic));
      topics_[topic] = receiveText(header.type);
      if (gone_) break;
      continue;
    }
    if (header.kind != Header::kMessage) {
      std::string text = receiveText(header.bytes);
      if (header.kind == Header::kCannotOpen) throw std::runtime_error(text);
      return text;
    }
    BagMessage message;
    message.topic = absoluteTopic(receiveText(header.topic));
    message.type = receiveText(header.type);
    message.md5 = receiveText(header.md5);
    message.publisher = receiveText(header.publisher);
    message.bytes.resize(header.bytes);
    if (gone_ || !receive(message.bytes.data(), message.bytes.size(), kPatienceMs)) break;
    message.received = ros::Time(header.sec, header.nsec);
    message.clock = ros::Time(header.clock_sec, header.clock_nsec);
    gone_ = true;
    visit(message);
  }
  gone_ = true;
  return kCrashed;
}

}  // namespace deformable_contact_monitor
