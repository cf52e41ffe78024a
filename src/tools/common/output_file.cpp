// Writes the files of the tools under a temporary name, and renames them once they are complete.
#include "tools/common/output_file.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "core/mesh_file.h"

namespace deformable_contact_monitor {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void throwNotWritten(const std::string& path) {
  throw std::system_error(errno, std::generic_category(), path + ": cannot be written");
}

// The temporary names of unfinished files, for a signal that ends the process. What is beyond these
// stays then.
std::array<std::atomic<const char*>, 16> unfinished{};

void endBySignal(int signal) {
  for (const auto& name : unfinished) {
    const char* const path = name;
    if (path != nullptr) unlink(path);
  }
  std::raise(signal);  // its handler is the default one again
}

// Has unfinished files removed where Ctrl-C or kill ends the process. Handlers of others stay.
void handleSignals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction handler {};
    sigaction(signal, nullptr, &handler);
    if (handler.sa_handler != SIG_DFL) continue;
    handler.sa_handler = endBySignal;
    handler.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(signal, &handler, nullptr);
  }
}

// Replaces a name, or nothing, by another one.
void replaceUnfinished(const char* before, const char* after) {
  for (auto& name : unfinished) {
    const char* expected = before;
    if (name.compare_exchange_strong(expected, after)) return;
  }
}

}  // namespace

// The process id in the temporary name keeps two processes apart that write the same file.
AtomicFile::AtomicFile(const std::string& path) : path_(path), temporary_(path) {
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  if (fs::exists(status)) {
    // A device or a pipe cannot be replaced, so it is written to directly.
    if (!fs::is_regular_file(status)) return;
    if (access(path.c_str(), W_OK) != 0) throwNotWritten(path);
    // Renaming over a symbolic link would replace the link, so its target is written.
    const fs::path target = fs::canonical(path, none);
    if (!none) path_ = target.string();
  }
  temporary_ = path_ + "." + std::to_string(getpid()) + ".part";
  replaceUnfinished(nullptr, temporary_.c_str());
  handleSignals();
}

AtomicFile::~AtomicFile() {
  if (!isPlain()) return;
  if (!finished_) std::remove(temporary_.c_str());
  replaceUnfinished(temporary_.c_str(), nullptr);
}

void AtomicFile::finish() {
  if (isPlain() && std::rename(temporary_.c_str(), path_.c_str()) != 0) throwNotWritten(path_);
  finished_ = true;
}

// Opens the temporary file once, to see whether it can be written.
OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path == "-") {
    stream_ = stdout;
    return;
  }
  const AtomicFile file(path);
  std::FILE* const opened = open(file.writtenAs());
  if (file.isPlain()) {
    std::fclose(opened);
  } else {
    stream_ = opened;
  }
}

OutputFile::~OutputFile() {
  if (stream_ != nullptr && stream_ != stdout) std::fclose(stream_);
}

void OutputFile::write(std::string_view text) {
  if (stream_ != nullptr) return writeTo(stream_, text);
  AtomicFile atomic(path_);
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open(atomic.writtenAs()), std::fclose);
  writeTo(file.get(), text);
  if (std::fclose(file.release()) != 0) fail();
  atomic.finish();
}

std::FILE* OutputFile::open(const std::string& path) const {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) fail();
  return file;
}

void OutputFile::writeTo(std::FILE* file, std::string_view text) const {
  if (std::fwrite(text.data(), 1, text.size(), file) != text.size() || std::fflush(file) != 0) {
    fail();
  }
}

void OutputFile::fail() const { throwNotWritten(path_ == "-" ? "standard output" : path_); }

TableFile::TableFile(const std::string& path)
    : path_(path), atomic_(path), file_(atomic_.writtenAs(), std::ios::binary) {
  if (!file_) fail();
}

void TableFile::line(const std::string& text) {
  file_ << text << '\n';
  if (!file_) fail();
}

void TableFile::finish() {
  file_.close();
  if (!file_) fail();
  atomic_.finish();
}

void TableFile::fail() const { throwNotWritten(path_); }

void makeFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::system_error(error, folder + ": cannot be made");
}

void refuseMeshAsOutput(const std::string& option, const std::string& file) {
  if (!isMeshFileName(file)) return;
  throw std::invalid_argument(option + ": would write over the mesh file " + file +
                              "; it takes a file to write or - (see --help)");
}

}  // namespace deformable_contact_monitor
