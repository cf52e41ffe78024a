#include "python/others_run.h"

#include <pybind11/pybind11.h>
#include <unistd.h>

#include <chrono>
#include <thread>

namespace deformable_contact_monitor {
namespace {

namespace py = pybind11;

// All are read and written with Python's global lock only.
struct Others {
  pid_t process = getpid();
  int running = 0;
  bool ending = false;
  std::thread::id ended_by;
};

// Threads of the parent do not run in a forked process, which starts with new counts.
Others& others() {
  static Others all;
  if (all.process != getpid()) all = Others();
  return all;
}

// Functions that Python calls later in the same thread may go on to use the package.
void waitForOthers() {
  constexpr std::chrono::seconds kMost(5);
  const auto until = std::chrono::steady_clock::now() + kMost;
  others().ending = true;
  others().ended_by = std::this_thread::get_id();
  while (others().running > 0 && std::chrono::steady_clock::now() < until) {
    const py::gil_scoped_release released;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

AtWork::AtWork() {
  if (others().ending && others().ended_by != std::this_thread::get_id()) {
    const py::gil_scoped_release released;
    while (true) pause();
  }
  ++others().running;
}

AtWork::~AtWork() { --others().running; }

void waitForOthersAtExit() {
  py::module::import("atexit").attr("register")(py::cpp_function(&waitForOthers));
}

}  // namespace deformable_contact_monitor
