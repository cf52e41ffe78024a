// Lets the interpreter end while other Python threads are in C++.
#pragma once

namespace deformable_contact_monitor {

// Says that this thread is in C++ code which lets other Python threads run: without Python's global
// lock, or in numpy, which releases it while it copies. If the interpreter ends meanwhile, Python
// ends a daemon thread, such as one of rospy's, as soon as it takes the lock again. C++ does not
// allow that, and the process aborts or crashes. So the interpreter's end waits for threads at
// work, at most 5 s, and threads that would begin after that stop.
//
// Create it while holding the lock, and destroy it while holding the lock again, after the Python
// objects of the results are made. A thread makes one at a time.
class AtWork {
 public:
  AtWork();
  ~AtWork();
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;
};

// Makes the end of the interpreter wait. Call it once, with Python's global lock.
void waitForOthersAtExit();

}  // namespace deformable_contact_monitor
