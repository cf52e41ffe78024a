// A scene of a step, cut into sub-steps.
#pragma once

#include <optional>
#include <vector>

#include "core/ccd/body_motion.h"
#include "core/scene.h"
#include "core/substeps.h"

namespace deformable_contact_monitor {

// Of bodies some of which turn. What it is made of must outlive it.
class TurningScene {
 public:
  // `motions`: of the bodies that turn. `scene` becomes a copy of `step`, with pairs of two
  // different bodies of which one turns or both do. The tolerance is > 0 [m].
  TurningScene(const Scene& step, const std::vector<std::optional<BodyMotion>>& motions,
               double tolerance_m, Scene* scene);

  // Where to cut so that nobody deviates by more than the tolerance, but at most so often.
  std::vector<double> cuts(int most) const;

  // Brings all bodies to their states at both ends, and sets their pads: what a body has of its
  // own, and what it deviates. Sub-steps are to come in order.
  void moveTo(double from, double to);

  // The largest sum of the pads of an enabled pair, rounded up.
  float largestPad() const;

  // As StepResult says, ascending.
  std::vector<BodyId> outlying() const;

 private:
  // A body that moves straight, in the scene frame.
  struct Straight {
    HostList<float> from, to;
    double rounding;
    bool has_outliers;
  };

  double deviation(double from, double to) const;
  Straight straightMotion(const Body& body) const;
  // Return how far the body's points are from where they are in truth, at most [m].
  double moveTurning(BodyId id, double from, double to);
  double moveStraight(BodyId id, double from, double to);

  const Scene* step_;
  const std::vector<std::optional<BodyMotion>>* motions_;
  double tolerance_m_;
  double horizon_;  // beyond it vertices are outliers [m]
  Scene* scene_;
  std::vector<std::optional<Straight>> straight_;
};

}  // namespace deformable_contact_monitor
