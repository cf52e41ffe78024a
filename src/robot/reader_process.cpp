// A running read_link_mesh.
#include "robot/reader_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "robot/link_mesh_file.h"

namespace deformable_contact_monitor {
namespace {

using std::chrono::milliseconds;

// How late a stop or a deadline may be seen.
constexpr milliseconds kPollTime{20};

// A process that was killed is gone in no time, unless a file system keeps hold of it. Then it is
// left to the kernel.
constexpr milliseconds kExitTime{1000};

[[noreturn]] void failed(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

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

ReaderProcess::ReaderProcess(const std::string& program, const std::string& mesh_file,
                             milliseconds max_time, std::function<bool()> stop)
    : max_time_(max_time), deadline_(Clock::now() + max_time), stop_(std::move(stop)) {
  int ends[2];
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
  if (signal == SIGXCPU) {
    throw std::runtime_error("takes more than " + std::to_string(kMaxCpuS) +
                             " s of the processor to read");
  }
  throw std::runtime_error(
      std::string(signal == SIGKILL ? "its reader was killed" : "its reader crashed") +
      " (signal " + std::to_string(signal) + ", " + strsignal(signal) + ")");
}

// Of a process that has ended or is about to; nothing if it does not end, or if others took it.
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
