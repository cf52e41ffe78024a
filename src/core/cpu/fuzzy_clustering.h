// Fuzzy c-means (Bezdek 1981) on a subsample of the triangles' centroids.
//
// The prototypes steer speed only: the half-space rule is complete for any of them, converged or
// not. Memberships are computed in the ratio form, which is total: no division by zero, no
// overflow.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/rules/clustering.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

// Runs fuzzy c-means. Points and prototypes are in scaled coordinates; up to 1e6 away from the
// origin is fine.
class FuzzyClustering {
 public:
  // `fuzzifier` m is in [1.05, 4]: towards 1 it becomes hard k-means, larger values are softer. The
  // limit must outlive this object. Once it is over, the prototypes are unspecified.
  explicit FuzzyClustering(float fuzzifier, const CycleLimit& limit = noLimit())
      : powers_{fuzzifier}, limit_(limit) {}

  // Starts from the means of the points nearest to each of `count` of them, evenly spread over
  // their order. (A prototype on a point would hardly move from there.)
  void initialise(const std::vector<Vec3f>& points, std::size_t count);

  // Starts from given prototypes.
  void setPrototypes(std::vector<Vec3f> prototypes) { prototypes_ = std::move(prototypes); }
  const std::vector<Vec3f>& prototypes() const { return prototypes_; }

  // One alternation: memberships of all points, then prototypes. Returns the objective
  // sum u^m d^2 at the prototypes before the call, with their optimal memberships; it does not rise
  // from call to call on the same points. A prototype that no point belongs to stays.
  double iterate(const std::vector<Vec3f>& points);

  // Returns the memberships of one point, one per prototype, in [0, 1]; their sum is 1.
  std::vector<float> memberships(const Vec3f& point) const;

 private:
  FuzzyPowers powers_;
  const CycleLimit& limit_;
  std::vector<Vec3f> prototypes_;
};

}  // namespace deformable_contact_monitor
