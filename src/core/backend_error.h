// Failures of a backend, by what helps against them.
#pragma once

#include <stdexcept>
#include <string>

#include "core/export.h"

namespace deformable_contact_monitor {

enum class BackendFault {
  kTransient,      // out of memory, device busy: made anew later, it may work
  kSticky,         // this process will never get an answer from the device again
  kSceneTooLarge,  // not the device's fault: smaller scenes go on
  kUnavailable,    // no such device, no driver, not in this build
};

// what() is one line that names the call and the backend's own reason.
class DCM_EXPORT BackendError : public std::runtime_error {
 public:
  BackendError(BackendFault fault, const std::string& what)
      : std::runtime_error(what), fault_(fault) {}
  BackendFault fault() const { return fault_; }

 private:
  BackendFault fault_;
};

}  // namespace deformable_contact_monitor
