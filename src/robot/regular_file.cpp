// Reads a regular file whole, without waiting for a FIFO or device that has taken its place.
#include "robot/regular_file.h"

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
  // Opens with O_NONBLOCK, because the path may have become a FIFO since it was checked, and
  // opening a FIFO waits for a writer.
  explicit OpenFile(const std::string& path)
      : number_(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (number_ >= 0) close(number_);
  }
  int number() const { return number_; }  // < 0: could not be opened, see errno

 private:
  const int number_;
};

// Throws an error for the system's error number.
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

// Throws if a file is too large to be read whole.
void requireModest(std::size_t bytes) {
  if (bytes <= kMaxFileMib * kBytesPerMib) return;
  throw std::runtime_error("is larger than " + std::to_string(kMaxFileMib) + " MiB");
}

// Reads to the end of the file: the size that the system tells is not always true, as in /proc.
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
  // The path is checked before it is opened, because opening a device may have effects, and the
  // open file is checked again, because the path may have been replaced in between.
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
