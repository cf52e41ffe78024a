// Starts read_link_mesh, reads its answer within a deadline, and says how it ended. It uses
// posix_spawn and a pipe. The process is killed with the object, so no reader outlives the call
// that needs it.
#include "robot/reader_process.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "robot/link_mesh_files.h"

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;
namespace fs = std::filesystem;

constexpr char kProgram[] = "read_link_mesh";
constexpr char kPackage[] = "deformable_contact_monitor";

// Returns the folder of the program or shared library that contains this function, without symbolic
// links; empty if it is unknown.
fs::path thisFolder() {
  std::error_code error;
  Dl_info info;
  link_map* object = nullptr;
  const int found = dladdr1(reinterpret_cast<const void*>(&thisFolder), &info,
                            reinterpret_cast<void**>(&object), RTLD_DL_LINKMAP);
  const bool is_library = found != 0 && object != nullptr && *object->l_name != '\0';
  const fs::path file = is_library ? object->l_name : "/proc/self/exe";
  return fs::canonical(file, error).parent_path();
}

// Returns the folders in which the program may be, in the order in which they are tried.
std::vector<fs::path> places() {
  std::vector<fs::path> folders;
  const fs::path here = thisFolder();
  if (!here.empty()) folders = {here, here / kPackage};
  const char* workspaces = std::getenv("CMAKE_PREFIX_PATH");
  std::istringstream list(workspaces == nullptr ? "" : workspaces);
  for (std::string workspace; std::getline(list, workspace, ':');) {
    if (!workspace.empty()) folders.push_back(fs::path(workspace) / "lib" / kPackage);
  }
  return folders;
}

// A stop or a deadline is noticed at most this much later.
constexpr milliseconds kPollTime{20};

// A killed process ends at once, unless a file system blocks it. After this time it is left to the
// kernel.
constexpr milliseconds kExitTime{1000};

// Throws an error with the system's text for `error`.
[[noreturn]] void failed(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

// Holds the attributes of the new process: it has its own process group and default signals, and
// its output goes to our pipe.
class SpawnSettings {
 public:
  explicit SpawnSettings(int output) {
    posix_spawn_file_actions_init(&files_);
    posix_spawn_file_actions_adddup2(&files_, output, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    sigset_t all, none;
    sigfillset(&all);
    sigemptyset(&none);
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);  // roscpp ignores SIGPIPE
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&files_);
    posix_spawnattr_destroy(&attributes_);
  }
  const posix_spawn_file_actions_t* files() const { return &files_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t files_;
  posix_spawnattr_t attributes_;
};

}  // namespace

std::string findReaderProgram() {
  std::string looked;
  for (const fs::path& folder : places()) {
    const fs::path program = folder / kProgram;
    std::error_code error;
    if (fs::is_regular_file(program, error) && access(program.c_str(), X_OK) == 0) return program;
    looked += (looked.empty() ? "" : ", ") + folder.string();
  }
  throw std::runtime_error(std::string("the program ") + kProgram +
                           ", which reads mesh files, is missing; it was looked for in " + looked);
}

ReaderProcess::ReaderProcess(const std::string& program, const std::string& mesh_file,
                             milliseconds max_time, std::function<bool()> stop)
    : max_time_(max_time), deadline_(Clock::now() + max_time), stop_(std::move(stop)) {
  int ends[2];
  // O_CLOEXEC keeps the pipe from other programs that this process starts. If one of them held the
  // writing end, the pipe would not end with the reader.
  if (pipe2(ends, O_CLOEXEC) != 0) failed(errno, "no pipe to its reader");
  output_ = ends[0];
  try {
    start(program, mesh_file, ends[1]);
  } catch (...) {
    close(ends[1]);
    close(output_);
    throw;
  }
  close(ends[1]);
}

void ReaderProcess::start(const std::string& program, const std::string& mesh_file,
                          int its_output) {
  std::string arguments[] = {program, mesh_file};
  char* argv[] = {arguments[0].data(), arguments[1].data(), nullptr};
  const SpawnSettings settings(its_output);
  const int error = posix_spawn(&process_, program.c_str(), settings.files(), settings.attributes(),
                                argv, environ);
  if (error != 0) {
    process_ = 0;
    failed(error, program + ", which would read it, cannot be started");
  }
}

ReaderProcess::~ReaderProcess() {
  if (process_ > 0) {
    // Kills the whole process group. Reading the exit status removes the ended process from the
    // system.
    kill(-process_, SIGKILL);
    exitStatus();
  }
  close(output_);
}

void ReaderProcess::read(void* to, std::size_t bytes) {
  auto* at = static_cast<char*>(to);
  while (bytes > 0) {
    waitForOutput();
    const ssize_t count = ::read(output_, at, bytes);
    // The pipe has ended, and the answer is not complete.
    if (count == 0) throwHowItEnded();
    if (count < 0 && errno != EINTR) failed(errno, "its reader's answer was lost");
    if (count > 0) {
      at += count;
      bytes -= static_cast<std::size_t>(count);
    }
  }
}

void ReaderProcess::waitForOutput() const {
  while (true) {
    if (stop_ && stop_()) throw ReadingStopped();
    const auto left = std::chrono::ceil<milliseconds>(deadline_ - Clock::now());
    if (left.count() <= 0) {
      std::ostringstream text;
      text << "takes longer than " << std::chrono::duration<double>(max_time_).count()
           << " s to read";
      throw std::runtime_error(text.str());
    }
    pollfd output{output_, POLLIN, 0};
    const int ready = poll(&output, 1, static_cast<int>(std::min(left, kPollTime).count()));
    if (ready > 0) return;
    if (ready < 0 && errno != EINTR) failed(errno, "its reader's answer was lost");
  }
}

void ReaderProcess::throwHowItEnded() {
  const std::optional<int> status = exitStatus();
  if (!status) throw std::runtime_error("its reader gave no answer");
  if (!WIFSIGNALED(*status)) {
    throw std::runtime_error("its reader ended with code " + std::to_string(WEXITSTATUS(*status)) +
                             " and gave no answer");
  }
  const int signal = WTERMSIG(*status);
  // The kernel sends this signal at the limit of processor time that the reader sets for itself.
  if (signal == SIGXCPU) {
    throw std::runtime_error("takes more than " + std::to_string(kMaxCpuS) +
                             " s of the processor to read");
  }
  throw std::runtime_error(
      std::string(signal == SIGKILL ? "its reader was killed" : "its reader crashed") +
      " (signal " + std::to_string(signal) + ", " + strsignal(signal) + ")");
}

// Returns the exit status of a process that has ended or is about to end; nothing if it does not
// end, or if somebody else has read its status. waitpid() has no timeout, so it is called again and
// again with growing pauses.
std::optional<int> ReaderProcess::exitStatus() {
  const Clock::time_point last_try = Clock::now() + kExitTime;
  std::chrono::microseconds pause{50};
  while (true) {
    int status = 0;
    const pid_t ended = waitpid(process_, &status, WNOHANG);
    if (ended == process_ || (ended < 0 && errno != EINTR)) {
      const bool is_known = ended == process_;
      process_ = 0;
      return is_known ? std::optional<int>(status) : std::nullopt;
    }
    if (Clock::now() >= last_try) return std::nullopt;
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, std::chrono::microseconds(10'000));
  }
}

}  // namespace deformable_contact_monitor
