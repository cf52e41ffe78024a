// Which bodies have no transform, since when, and how much that matters.
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <map>
#include <string>

#include "core/steady_time.h"
#include "monitor/cycle/monitor_scene.h"

namespace deformable_contact_monitor {

// One thread at a time. Reads no clock.
class TransformWatch {
 public:
  // What a cycle asked for, and did not get. Bodies of other cycles are as they were.
  void record(const TransformReport& report, SteadyTime now);

  // A warning that names the bodies without a transform, an error once one of them has had none for
  // more than 5 s; then the longest wait since the last description. Bodies that no cycle has asked
  // for during 30 s are forgotten: nobody knows how they stand.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status, SteadyTime now);

 private:
  struct Missing {
    SteadyTime since, last_asked;
    std::string problem;
  };

  std::map<std::string, Missing> missing_;  // by body
  std::uint64_t misses_ = 0;
  double worst_wait_s_ = 0;
};

}  // namespace deformable_contact_monitor
