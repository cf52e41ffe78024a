// Failures of a backend, classified by what helps against them.
#pragma once

#include <stdexcept>
#include <string>

#include "core/export.h"

namespace deformable_contact_monitor {

enum class BackendFault {
  kTransient,      // out of memory or device busy: a new detector may work later
  kSticky,         // the device will never work again in this process
  kSceneTooLarge,  // the device works, and smaller scenes do too
  kUnavailable,    // no such device, no driver, or not part of this build
};

// what() is one line with the call that failed and the backend's own reason.
class DCM_EXPORT BackendError : public std::runtime_error {
 public:
  BackendError(BackendFault fault, const std::string& what)
      : std::runtime_error(what), fault_(fault) {}
  BackendFault fault() const { return fault_; }

 private:
  BackendFault fault_;
};

}  // namespace deformable_contact_monitor
