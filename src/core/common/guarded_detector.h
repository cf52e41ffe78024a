// Makes a detector safe to use, and to destroy, in a process that was forked after it was made.
#pragma once

#include <memory>

#include "core/detector.h"
#include "core/export.h"

namespace deformable_contact_monitor {

// Says what a detector can do in a forked process.
enum class AfterFork {
  kWorks,         // it detects there, unless the fork came while another thread was in detect()
  kIsUnavailable  // it never works there, because it uses threads of its own or a device
};

// Returns a detector that does what `detector` does. In a forked process where it does not work,
// detect() and swapResult() throw a BackendError (kUnavailable), reset() does nothing, and the
// destructor leaves the detector's memory as it is.
DCM_EXPORT std::unique_ptr<Detector> guardAgainstForks(std::unique_ptr<Detector> detector,
                                                       AfterFork after_fork);

}  // namespace deformable_contact_monitor
