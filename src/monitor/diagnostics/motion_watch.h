// How swept motion goes: steps, what they find, what they lack.
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <string>

#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// One thread at a time.
class MotionWatch {
 public:
  void record(const CycleReport& report);

  // A warning where a step of the time since the last description was not complete, or was missing
  // for another reason than that there was nothing to start from.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  void recordStep(const CycleReport& report, const SweepReport& sweep);

  std::uint64_t steps_ = 0, missing_ = 0, passed_ = 0;  // since the start
  std::string why_missing_;                             // the last one
  std::string problem_;                                 // since the last description
  std::uint64_t pairs_ = 0;                             // of the last step
  int sub_steps_ = 0;
  float pad_m_ = 0;
};

}  // namespace deformable_contact_monitor
