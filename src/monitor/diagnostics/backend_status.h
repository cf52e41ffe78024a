// What the diagnostics and the console say of the backend.
#pragma once

#include <string>

#include "core/fallback_detector.h"
#include "cuda/detector_choice.h"

namespace deformable_contact_monitor {

struct BackendStatus {
  unsigned char level = 0;  // of diagnostic_msgs/DiagnosticStatus
  std::string summary;      // one line: why it is not CUDA, and what helps; empty: all is well
};

// ERROR if only a restart helps, and for whatever keeps CUDA from running where it was asked for by
// name; WARN if CUDA is tried again by itself. A scene that is too large is a WARN, asked or not:
// no device is at fault; so is one of several devices that is done without. OK, with a summary,
// where `auto` finds no CUDA at all: that is what it is for.
BackendStatus backendStatus(BackendChoice asked, const BackendState& state);

}  // namespace deformable_contact_monitor
