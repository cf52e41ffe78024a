// What one detection cycle hands to everything that is published from it.
#include "monitor/cycle_report.h"

#include <algorithm>

#include "core/common/rejected_triangles.h"

namespace deformable_contact_monitor {

bool hasGeometry(const CycleReport& report) {
  return report.options.geometry && report.result != nullptr &&
         report.result->geometry.size() == report.result->contacts.size();
}

// They are looked for only where the detector says that there are any.
void noteRejected(CycleReport* report) {
  if (report->result->counters.rejected == 0) return;
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(*report->scene);
  for (BodyId id = 0; id < report->bodies.size(); ++id) {
    BodyStatus& body = report->bodies[id];
    body.rejected = rejected[id].count;
    if (rejected[id].by_pose) body.unknown_because = "its pose makes vertices infinite";
  }
}

void noteInside(const CycleLimit& limit, ContainmentFinder* finder, CycleReport* report) {
  report->containment = nullptr;
  const DetectionResult& result = *report->result;
  const bool knows_apart = !result.cut_off || !result.distances.empty();
  if (!knows_apart || result.left_out > 0) return;
  report->containment = &finder->find(*report->scene, result, limit);
}

std::string stepProblem(const CycleReport& report) {
  for (const SweepReport& sweep : report.sweeps) {
    if (!sweep.problem.empty()) return "of a step: " + sweep.problem;
  }
  return "";
}

bool isOutOfTime(const CycleReport& report) {
  const bool step_is =
      std::any_of(report.sweeps.begin(), report.sweeps.end(), [](const SweepReport& sweep) {
        return sweep.result != nullptr && sweep.result->detection.isOutOfTime();
      });
  return step_is || (report.result != nullptr && report.result->isOutOfTime()) ||
         (report.containment != nullptr && report.containment->cut_off_because == kNoTime);
}

}  // namespace deformable_contact_monitor
