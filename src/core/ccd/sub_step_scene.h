// Moves a scene from one sub-step of a time interval to the next. It decides where the interval is
// cut, sets where each body is at both ends of a sub-step, and bounds how far the body's points may
// be from straight lines in between.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/ccd/body_motion.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Returns the largest deviation [m] of any point from its straight line in [from, to].
using DeviationBetween = std::function<double(double from, double to)>;

// Returns where to cut a time interval: ascending parts of it, from 0 to 1. No point deviates by
// more than `tolerance` [m] between two cuts. If that takes more than `most` pieces, it uses a
// larger tolerance that is enough. `samples`: ascending, from 0 to 1. Between two of them every
// point moves evenly on an arc, of which an nth part deviates by the deviation / n^2.
std::vector<double> cutInterval(const std::vector<double>& samples,
                                const DeviationBetween& deviation, double tolerance, int most);

// Moves a copy of a scene from sub-step to sub-step. The arguments of the constructor must outlive
// it.
class SubStepScene {
 public:
  // `motions`: one per body, empty for bodies that do not rotate. `scene` becomes a copy of
  // `whole`, with only those pairs of two different bodies in which a body rotates. The tolerance
  // is > 0 [m].
  SubStepScene(const Scene& whole, const std::vector<std::optional<BodyMotion>>& motions,
               double tolerance_m, Scene* scene);

  // Returns where to cut so that no body deviates by more than the tolerance, in at most `most`
  // pieces.
  std::vector<double> cuts(int most) const;

  // Sets all bodies to their states at both ends of a sub-step, and their pads to their own pad
  // plus their deviation. Sub-steps must come in order.
  void moveTo(double from, double to);

  // Returns the largest sum of the pads of an enabled pair [m], rounded up.
  float largestPad() const;

  // Returns StepResult::outlying, ascending.
  std::vector<BodyId> outlying() const;

 private:
  // A body that does not rotate. Its vertices move straight in the scene frame [m].
  struct Straight {
    HostList<float> from, to;
    double rounding;
    bool has_outliers;
  };

  double deviation(double from, double to) const;
  Straight straightMotion(const Body& body) const;
  // Return how far the body's points are from their true places, at most [m].
  double moveRotating(BodyId id, double from, double to);
  double moveStraight(BodyId id, double from, double to);

  const Scene* whole_;
  const std::vector<std::optional<BodyMotion>>* motions_;
  double tolerance_m_;
  double horizon_;  // vertices farther from the origin are outliers [m]
  Scene* scene_;
  std::vector<std::optional<Straight>> straight_;
};

}  // namespace deformable_contact_monitor
