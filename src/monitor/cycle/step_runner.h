// Finds the contacts of a cycle's steps.
#pragma once

#include <cstddef>
#include <deque>

#include "core/detector.h"
#include "core/scene.h"
#include "core/substeps.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// One thread at a time.
class StepRunner {
 public:
  // The detector must outlive this.
  explicit StepRunner(Detector& detector) : detector_(detector) {}

  // Sets the results of report->sweeps that have a `from`: valid until the next call. `scene` is
  // that of the cycle, report->scene; its pairs are the same afterwards, its earlier states are
  // those of the last step. A detection that fails costs its step alone, which says so (`problem`).
  // `options` are those of the cycle, with its limits; tolerance [m], 0: straight lines.
  // Before, report->result is copied and points to the copy from then on: a detector keeps but its
  // last result. Does nothing where there is no step.
  void run(const Options& options, double tolerance_m, Scene* scene, CycleReport* report);

 private:
  void runStep(const Options& options, double tolerance_m, Scene* scene, SweepReport* sweep,
               std::size_t number);

  Detector& detector_;
  DetectionResult of_stamp_;           // the cycle's own
  std::deque<SubStepDetector> steps_;  // by step of the cycle: each keeps its own result
  std::deque<StepResult> nothing_;     // of steps without a pair
};

}  // namespace deformable_contact_monitor
