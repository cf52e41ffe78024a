// Messages of bags, read so that a damaged bag costs only itself.
#include "tools/bags/bag_reader.h"

#include <fcntl.h>
#include <poll.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "tools/bags/bag_index.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kPatienceMs = 60000;  // with a reader that says nothing
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr rlim_t kMemory = RLIM_INFINITY;  // sanitizers ask for terabytes of addresses
#else
constexpr rlim_t kMemory = rlim_t{16} << 30;  // [bytes] that the reader may ask for
#endif
constexpr std::uint32_t kLongest = 0xC0000000;  // [bytes] of one message

// What goes through the pipe before the texts and the bytes.
struct Header {
  enum Kind : std::uint32_t { kMessage, kEnd, kCannotOpen };
  std::uint32_t kind = kEnd;
  std::uint32_t topic = 0, type = 0, md5 = 0, bytes = 0;  // lengths; kEnd, kCannotOpen: bytes alone
  std::uint32_t sec = 0, nsec = 0;
};

void send(int pipe, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t sent = write(pipe, at, size);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) _exit(0);  // nobody wants to know
    at += sent;
    size -= static_cast<std::size_t>(sent);
  }
}

void sendText(int pipe, Header::Kind kind, const std::string& text) {
  Header header;
  header.kind = kind;
  header.bytes = static_cast<std::uint32_t>(text.size());
  send(pipe, &header, sizeof header);
  send(pipe, text.data(), text.size());
}

// MessageInstance::write's stream.
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

void sendMessage(int pipe, const rosbag::MessageInstance& message) {
  std::vector<std::uint8_t> bytes(message.size());
  ByteStream stream{&bytes};
  message.write(stream);
  const std::string &topic = message.getTopic(), &type = message.getDataType(),
                    &md5 = message.getMD5Sum();
  Header header;
  header.kind = Header::kMessage;
  header.topic = static_cast<std::uint32_t>(topic.size());
  header.type = static_cast<std::uint32_t>(type.size());
  header.md5 = static_cast<std::uint32_t>(md5.size());
  header.bytes = static_cast<std::uint32_t>(bytes.size());
  header.sec = message.getTime().sec;
  header.nsec = message.getTime().nsec;
  send(pipe, &header, sizeof header);
  send(pipe, (topic + type + md5).data(), topic.size() + type.size() + md5.size());
  send(pipe, bytes.data(), bytes.size());
}

// Throws std::runtime_error for what rosbag would not call by its name.
void checkStart(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string start(13, '\0');
  if (!file || std::filesystem::is_directory(path)) throw std::runtime_error("cannot be read");
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  if (start.empty()) throw std::runtime_error("is empty");
  if (start.compare(0, 8, "#ROSBAG ") != 0) throw std::runtime_error("is no bag");
}

void checkIndex(const std::string& path) {
  try {
    checkBagIndex(path);
  } catch (const std::exception& error) {
    throw rosbag::BagFormatException(error.what());
  }
}

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

void readAll(int pipe, const std::vector<std::string>& paths, const BagSelection& selection) {
  std::deque<rosbag::Bag> bags;
  rosbag::View view;
  try {
    for (const std::string& path : paths) {
      openBag(path, &bags.emplace_back());
      view.addQuery(bags.back(), [&selection](const rosbag::ConnectionInfo* connection) {
        return selection.has(connection->topic, connection->datatype);
      });
    }
  } catch (const std::exception& error) {
    return sendText(pipe, Header::kCannotOpen, error.what());
  }
  try {
    for (const rosbag::MessageInstance& message : view) sendMessage(pipe, message);
    sendText(pipe, Header::kEnd, "");
  } catch (const std::bad_alloc&) {
    sendText(pipe, Header::kEnd, "a size in it is senseless");
  } catch (const std::exception& error) {
    sendText(pipe, Header::kEnd, *error.what() == '\0' ? "unreadable" : error.what());
  }
}

}  // namespace

bool BagSelection::has(const std::string& topic, const std::string& type) const {
  const auto of_topic = types_of_topics.find(topic);
  return types.count(type) > 0 || (of_topic != types_of_topics.end() && of_topic->second == type);
}

BagReader::BagReader(std::vector<std::string> paths, BagSelection selection)
    : paths_(std::move(paths)), selection_(std::move(selection)) {
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

void BagReader::serve() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  signal(SIGPIPE, SIG_IGN);
  const rlimit no_core{0, 0}, memory{kMemory, kMemory};
  setrlimit(RLIMIT_CORE, &no_core);
  setrlimit(RLIMIT_AS, &memory);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  dup2(nowhere, STDERR_FILENO);  // the allocator's last words
  char request = 0;
  while (::read(requests_, &request, 1) == 1) readAll(messages_, paths_, selection_);
  _exit(0);
}

bool BagReader::receive(void* data, std::size_t size) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    pollfd waiting{messages_, POLLIN, 0};
    const int ready = poll(&waiting, 1, kPatienceMs);
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
  if (!receive(text.data(), size)) gone_ = true;
  return text;
}

std::string BagReader::read(const std::function<void(const BagMessage&)>& visit) {
  constexpr const char* kCrashed = "rosbag's own reader fails on it";
  const char request = 1;
  if (gone_ || write(requests_, &request, 1) != 1) return kCrashed;
  gone_ = true;  // unless all goes well
  Header header;
  while (receive(&header, sizeof header)) {
    gone_ = false;
    if (header.bytes > kLongest) break;
    if (header.kind != Header::kMessage) {
      std::string text = receiveText(header.bytes);
      if (header.kind == Header::kCannotOpen) throw std::runtime_error(text);
      return text;
    }
    BagMessage message;
    message.topic = receiveText(header.topic);
    message.type = receiveText(header.type);
    message.md5 = receiveText(header.md5);
    message.bytes.resize(header.bytes);
    if (gone_ || !receive(message.bytes.data(), message.bytes.size())) break;
    message.received = ros::Time(header.sec, header.nsec);
    gone_ = true;
    visit(message);
  }
  gone_ = true;
  return kCrashed;
}

}  // namespace deformable_contact_monitor
