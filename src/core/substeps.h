// Contacts of a step in which bodies turn: their points' true ways are arcs. The step is cut into
// sub-steps until straight lines are close enough, and what is left of the arc is a pad.
#pragma once

#include <vector>

#include "core/detector.h"
#include "core/export.h"
#include "core/options.h"
#include "core/rules/rigid_transform.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Where a body was at a part [0, 1] of the step.
struct DCM_EXPORT PoseSample {
  double at;
  RigidTransform pose;
};

// A rigid body's way: between samples its origin moves on a straight line and its rotation turns
// about one axis, both evenly (as tf2 interpolates). Ascending; the first at 0 and the last at 1.
// Empty: the body's vertices move straight from Scene's earlier state to the present one.
using BodyPath = std::vector<PoseSample>;

struct DCM_EXPORT StepResult {
  // Of the whole step: options.motion is swept in it. Counters, times and memory are sums or, of
  // sizes, the largest.
  DetectionResult detection;
  int sub_steps = 1;  // of pairs with a body that turns
  float pad_m = 0;    // of two such bodies: largest sum of pads; 0: every pair is exact
};

class DCM_EXPORT SubStepDetector {
 public:
  // The detector must outlive this.
  explicit SubStepDetector(Detector& detector) : detector_(detector) {}

  // Every contact of the step from the bodies' earlier states to their present ones. `paths`: one a
  // body. Pairs with a body that turns are looked at in as many sub-steps as bring the arcs'
  // deviation from straight lines under `tolerance_m`, at most kMostSubSteps; their pads cover the
  // rest. Others, and all with tolerance_m 0, move straight, exactly. Errors as of
  // Detector::detect(); and std::invalid_argument, naming the body, at a path that is not as
  // BodyPath says. The result belongs to this, until the next call.
  const StepResult& detect(const Scene& scene, const std::vector<BodyPath>& paths,
                           double tolerance_m, const Options& options);

 private:
  Detector& detector_;
  StepResult result_;
};

constexpr int kMostSubSteps = 64;

}  // namespace deformable_contact_monitor
