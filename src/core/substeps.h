// Continuous collision detection of bodies that rotate. Their points move on arcs, and detectors
// know only straight lines. So the time interval is cut into sub-steps, until straight lines are
// close enough to the arcs, and the remaining deviation becomes a pad around each body.
#pragma once

#include <optional>
#include <vector>

#include "core/body_path.h"
#include "core/detector.h"
#include "core/export.h"
#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

struct DCM_EXPORT StepResult {
  // The result of the whole interval, with swept motion. Counters, times and left_out are sums over
  // the sub-steps (a pair that is found in several counts in each); sizes are the largest ones.
  // A contact that no straight line makes is within_pad. `nearest` is of the present state, and has
  // no pairs of a sub-step that the limits left out. Of the first time of a contact this is
  // certain for the given paths:
  // - Before `low` there is no contact. A pair with a pad has the time before which the two
  //   triangles are farther apart than the pad; a pair without one, that on the straight lines.
  // - At some time in [low, high] the triangles are at most the pad apart; without a pad, they
  //   touch. For contacts that are within_pad, `high` is 1, and they may never come so near.
  DetectionResult detection;
  int sub_steps = 1;  // for pairs with a body that rotates
  float pad_m = 0;    // the largest sum of the pads of such a pair [m]; 0: no body rotates
  // Bodies that do not rotate and have vertices so far away that rounding them in sub-steps would
  // cost more than the tolerance, and at least 16 times as far as any body that rotates. In
  // sub-steps the triangles of these vertices take no part, and count as rejected.
  std::vector<BodyId> outlying;
};

constexpr int kMostSubSteps = 64;

class BodyMotion;

// Keeps copies of scenes from call to call. One thread at a time.
class DCM_EXPORT SubStepDetector {
 public:
  // The detector must outlive this object.
  explicit SubStepDetector(Detector& detector) : detector_(detector) {}

  // Finds every contact in the interval from the bodies' earlier states to their present ones.
  // `paths`: one per body.
  //
  // A body rotates if its path takes some point further from its straight line than rounding to
  // float32 does. Pairs with such a body are detected in sub-steps. In each of them no point of
  // either body deviates by more than `tolerance_m`; but there are at most kMostSubSteps, and if
  // these are not enough, deviations are larger. The deviation, and half an ulp of each coordinate,
  // are added to the pads of both bodies, so all contacts of the true motion are found.
  // All other pairs move straight in one step, exactly; with tolerance_m 0 all pairs do. A body
  // that rotates moves straight in its own frame, so its contacts with itself are found there, in
  // one step.
  //
  // Limits hold for the whole call. Throws as Detector::detect() does. Also throws
  // std::invalid_argument for another number of paths, for a tolerance that is not finite and >= 0,
  // and, naming the body, for a path that breaks the rules of BodyPath, and for vertices on a
  // device if the body rotates or is in a pair with one that does. The result belongs to this
  // object and is valid until the next call.
  const StepResult& detect(const Scene& scene, const std::vector<BodyPath>& paths,
                           double tolerance_m, const Options& options);

  // Hands the result of the last detect() over to `result`, as Detector::swapResult() does.
  void swapResult(StepResult& result);

 private:
  void detectRotating(const Scene& step, const std::vector<std::optional<BodyMotion>>& motions,
                      double tolerance_m, const Options& options);

  Detector& detector_;
  StepResult result_;
  DetectionResult part_;  // of one detection
  Scene step_, straight_, rotating_;
};

}  // namespace deformable_contact_monitor
