// Finds everything that the report of a cycle tells about contacts: those at the stamp, parts that
// lie within other bodies, and contacts in the time intervals that end with the cycle.
#pragma once

#include <deque>
#include <memory>

#include "core/analysis/containment.h"
#include "core/detector.h"
#include "core/limits.h"
#include "core/scene.h"
#include "core/substeps.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

struct DetectionSettings {
  bool containment = false;      // also looks for parts that lie within other bodies
  double swept_tolerance_m = 0;  // see SubStepDetector::detect(); 0: rotating bodies move straight
  // Does not call the detector in a cycle without an enabled pair, because a detector without pairs
  // forgets the warm start of its next cycle.
  bool keep_warm_start = false;
};

// Keeps the buffers of the last cycle for the next one. One thread at a time.
class CycleDetection {
 public:
  // The detector must outlive this.
  CycleDetection(Detector& detector, const DetectionSettings& settings);

  // Runs the detection of one cycle with report->options, which includes a search for the nearest
  // pairs at the stamp, and fills the report: scene, result, containment, backend, rejected
  // triangles, and the result of each of report->sweeps that has a `from`. `scene` is the prepared
  // scene of the cycle. Its enabled pairs are the same afterwards; its earlier states are those of
  // the last interval. `limits` hold for all of it.
  // `needs_geometry` asks for contact geometry even if the options do not.
  // Throws what the detector throws; the report then has no result. An interval whose detection
  // fails does not throw: its `problem` says why.
  void run(const Limits& limits, bool needs_geometry, Scene* scene, CycleReport* report);

 private:
  // The detector of one time interval of a cycle, with what it found last.
  struct Interval {
    explicit Interval(Detector& detector) : detector(detector) {}

    SubStepDetector detector;
    std::shared_ptr<StepResult> result;
  };

  void detectAtStamp(const Options& options, const Scene& scene, CycleReport* report);
  void findInside(const Limits& limits, CycleReport* report);
  void runInterval(const Options& options, Scene* scene, Interval* interval, SweepReport* sweep);

  Detector& detector_;
  const DetectionSettings settings_;
  ContainmentFinder containment_;
  // Shared with the last report. They are used again once nobody else holds them.
  std::shared_ptr<DetectionResult> result_;
  std::deque<Interval> intervals_;
};

}  // namespace deformable_contact_monitor
