// Lets other Python threads run while C++ works, also at the end of the interpreter.
#pragma once

#include <pybind11/pybind11.h>

namespace deformable_contact_monitor {

// Releases Python's global lock for its lifetime. Unlike pybind11::gil_scoped_release alone, it
// does not abort the process where a daemon thread, such as one of rospy's, is within when the
// interpreter ends: Python would end that thread when it takes the lock again, which C++ does not
// allow. So the interpreter's end waits for work that has begun, at most 5 s, and threads that
// would begin after that stop.
class OthersRun {
 public:
  OthersRun() = default;
  OthersRun(const OthersRun&) = delete;
  OthersRun& operator=(const OthersRun&) = delete;

 private:
  // Counts the threads without the lock. Made and destroyed with it.
  struct Counted {
    Counted();
    ~Counted();
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
  };

  const Counted counted_;
  const pybind11::gil_scoped_release released_;
};

// Makes the end of the interpreter wait. Call it once, with Python's global lock.
void waitForOthersAtExit();

}  // namespace deformable_contact_monitor
