// Which backend runs, decided in one place.
#pragma once

#include <memory>
#include <string>

#include "core/detector.h"

namespace deformable_contact_monitor {

enum class BackendChoice { kAuto, kCuda, kCpu };

struct ChosenDetector {
  std::unique_ptr<Detector> detector;
  std::string warning;  // why it is not the backend that was asked for; empty: it is
};

ChosenDetector makeDetectorFor(BackendChoice choice);

}  // namespace deformable_contact_monitor
