// Contacts of a step in which bodies turn: their points' true ways are arcs. The step is cut into
// sub-steps until straight lines are close enough, and what is left of the arc is a pad.
#pragma once

#include <optional>
#include <vector>

#include "core/detector.h"
#include "core/export.h"
#include "core/options.h"
#include "core/rigid_transform.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Where a body was at a part [0, 1] of the step.
struct DCM_EXPORT PoseSample {
  double at;
  RigidTransform pose;
};

// A body's way: between samples its origin moves on a straight line and its rotation turns about
// one axis, by the smaller angle, both evenly (as tf2 interpolates). Ascending; the first at 0 and
// the last at 1: these two stand for Body::earlier's pose and Body::pose. If the body has earlier
// vertices, it deforms on this way: in its own frame they move straight to the present ones.
// Empty: the body's vertices move straight in the scene frame from Scene's earlier state to the
// present one.
using BodyPath = std::vector<PoseSample>;

struct DCM_EXPORT StepResult {
  // Of the whole step: options.motion is swept in it. Counters, times and left_out are sums (a pair
  // that is found in several sub-steps counts in each) or, of sizes, the largest. Times of a first
  // contact are those on the straight ways, rounded outwards; a contact that no straight way makes
  // is within_pad.
  DetectionResult detection;
  int sub_steps = 1;  // of pairs with a body that turns
  float pad_m = 0;    // of the two bodies of such a pair: the largest sum; 0: none turns
  // Bodies that move straight, some of their vertices so far off that rounding them in sub-steps
  // would cost more than the tolerance, and 16 times as far as any body that turns: in sub-steps
  // the triangles of these take no part, and count as rejected.
  std::vector<BodyId> outlying;
};

constexpr int kMostSubSteps = 64;

class BodyMotion;

// Keeps copies of scenes from step to step. One thread at a time.
class DCM_EXPORT SubStepDetector {
 public:
  // The detector must outlive this.
  explicit SubStepDetector(Detector& detector) : detector_(detector) {}

  // Every contact of the step from the bodies' earlier states to their present ones. `paths`: one a
  // body.
  //
  // A body turns if its path takes some point further from its straight line than rounding to
  // float32 does. Pairs with such a body are looked at in sub-steps, in each of which no point of
  // either deviates by more than `tolerance_m`; there are at most kMostSubSteps, with larger
  // deviations if need be. What is left of these, and half an ulp of each coordinate, is added to
  // the two bodies' pads, so that the true motion's contacts are all found. Other pairs, and all
  // with tolerance_m 0, move straight in one step, exactly. A body that turns moves straight in its
  // own frame, so there, in one step, are its contacts with itself looked for.
  //
  // Limits hold for the whole. Errors as of Detector::detect(); and std::invalid_argument at
  // another number of paths, at a tolerance that is not finite and >= 0, and, naming the body, at a
  // path that is not as BodyPath says and at vertices on a device of a body that turns, or that
  // moves beside one. The result belongs to this, until the next call.
  const StepResult& detect(const Scene& scene, const std::vector<BodyPath>& paths,
                           double tolerance_m, const Options& options);

 private:
  void detectTurning(const Scene& step, const std::vector<std::optional<BodyMotion>>& motions,
                     double tolerance_m, const Options& options);

  Detector& detector_;
  StepResult result_;
  Scene step_, straight_, turning_;
};

}  // namespace deformable_contact_monitor
