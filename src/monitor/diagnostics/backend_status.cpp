// What the diagnostics and the console say of the backend.
#include "monitor/diagnostics/backend_status.h"

#include <diagnostic_msgs/DiagnosticStatus.h>

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

unsigned char levelOf(BackendChoice asked, BackendFault fault) {
  const bool by_name = asked == BackendChoice::kCuda;
  switch (fault) {
    case BackendFault::kSticky:
      return DiagnosticStatus::ERROR;
    case BackendFault::kSceneTooLarge:
      return DiagnosticStatus::WARN;
    case BackendFault::kUnavailable:
      return by_name ? DiagnosticStatus::ERROR : DiagnosticStatus::OK;
    default:
      return by_name ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN;
  }
}

std::string adviceOf(const BackendState& state) {
  if (state.fault == BackendFault::kSticky) return "; CUDA needs a restart of this process";
  if (state.fault == BackendFault::kSceneTooLarge) return "; smaller scenes run on CUDA";
  return state.tried_again ? "; CUDA is tried again, at least once a minute" : "";
}

}  // namespace

BackendStatus backendStatus(BackendChoice asked, const BackendState& state) {
  if (state.problem.empty()) return {DiagnosticStatus::OK, ""};
  if (state.partly) {
    return {DiagnosticStatus::WARN,
            "contacts are found without one of the CUDA devices, until "
            "this process starts again: " +
                state.problem};
  }
  return {levelOf(asked, state.fault), "contacts are found on the CPU, for CUDA cannot be used: " +
                                           state.problem + adviceOf(state)};
}

}  // namespace deformable_contact_monitor
