// What a detection found in a cycle, as JSON, so that an evaluation can go on from there elsewhere.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "core/analysis/containment.h"
#include "core/detector.h"
#include "core/substeps.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// All that ContactSource::find() set, but what no evaluation looks at: contacts' geometry, and most
// counters. Numbers come back to the bit. Must come before the report's next detection.
nlohmann::json toRecord(const CycleReport& cycle);

// Holds what a report that was read from a record points to.
class RecordedCycle {
 public:
  // As ContactSource::find(), from a record of the same cycle, and until the next call. Throws
  // nlohmann::json::exception or std::runtime_error at what is no such record.
  void read(const nlohmann::json& record, CycleReport* cycle);

 private:
  DetectionResult result_;
  std::optional<Containment> containment_;
  std::vector<StepResult> steps_;  // as the report's
};

// Of what a cycle's contacts are the contacts of: enabled pairs, poses, margins, and the vertices
// of what deforms. The links' are the same in all cycles.
std::uint32_t sceneChecksum(const CycleReport& cycle);

}  // namespace deformable_contact_monitor
