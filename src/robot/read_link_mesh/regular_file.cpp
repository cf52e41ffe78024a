// A foreign file, whole.
#include "robot/read_link_mesh/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "robot/reading_limits.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

class OpenFile {
 public:
  // It may have become something else than a regular file; nothing is waited for.
  explicit OpenFile(const std::string& path)
      : number_(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (number_ >= 0) close(number_);
  }
  int number() const { return number_; }  // < 0: see errno

 private:
  const int number_;
};

[[noreturn]] void failed(int error) {
  if (error == ENOENT || error == ENOTDIR) throw std::runtime_error("no such file");
  throw std::runtime_error("cannot be read: " + std::generic_category().message(error));
}

void requireRegular(const struct stat& status) {
  if (S_ISREG(status.st_mode)) return;
  const char* kind = S_ISDIR(status.st_mode)    ? "a folder"
                     : S_ISFIFO(status.st_mode) ? "a FIFO"
                     : S_ISSOCK(status.st_mode) ? "a socket"
                                                : "a device";
  throw std::runtime_error(std::string("is not a regular file, but ") + kind);
}

void requireModest(std::size_t bytes) {
  if (bytes <= kMaxFileMib * kBytesPerMib) return;
  throw std::runtime_error("is larger than " + std::to_string(kMaxFileMib) + " MiB");
}

// The size that a file tells is not always true, as in /proc.
std::string readAll(int file) {
  std::string bytes;
  while (true) {
    const std::size_t size = bytes.size();
    requireModest(size);
    bytes.resize(size + kBlockBytes);
    const ssize_t count = read(file, &bytes[size], kBlockBytes);
    if (count < 0 && errno != EINTR) failed(errno);
    bytes.resize(size + static_cast<std::size_t>(count < 0 ? 0 : count));
    if (count == 0) return bytes;
  }
}

}  // namespace

std::string readRegularFile(const std::string& path) {
  struct stat status;
  if (stat(path.c_str(), &status) != 0) failed(errno);
  requireRegular(status);
  const OpenFile file(path);
  if (file.number() < 0) failed(errno);
  if (fstat(file.number(), &status) != 0) failed(errno);
  requireRegular(status);
  requireModest(static_cast<std::size_t>(status.st_size));
  return readAll(file.number());
}

}  // namespace deformable_contact_monitor
