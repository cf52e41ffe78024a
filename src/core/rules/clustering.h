// The rules of the stage `cluster`: how many clusters a scene gets, which triangles stand for it in
// fuzzy c-means (Bezdek 1981), where prototypes start, and the powers of memberships.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// The numbers of clusters that a backend works best with, found by measurement.
struct ClusterCountPolicy {
  std::size_t triangles_each;
  std::size_t most;
  std::size_t one_below;  // triangles below which one cluster does
  // From this many clusters on, their number is a multiple of it, so that vector lanes or
  // processors have equal work.
  std::size_t multiple;
};

// Returns the number of clusters for `triangles` triangles. `asked` is the number that the user
// wants, or 0 if the scene decides; `current` is the present number, or 0. It keeps a number that
// is about right, because a new number needs new clusters.
inline std::size_t clusterCountFor(int asked, const ClusterCountPolicy& policy,
                                   std::size_t triangles, std::size_t current) {
  if (asked > 0) return std::min(static_cast<std::size_t>(asked), triangles);
  const std::size_t one_below = current > 1 ? policy.one_below / 2 : policy.one_below;
  if (triangles < one_below) return std::min<std::size_t>(triangles, 1);
  std::size_t wanted = std::min(policy.most, triangles / policy.triangles_each + 1);
  if (wanted > policy.multiple) wanted -= wanted % policy.multiple;
  return 3 * current > 2 * wanted && 2 * current < 3 * wanted ? current : wanted;
}

// Selects `samples` of `triangles` triangles, 0 < samples <= triangles, evenly spread over their
// order. Sample s is the first triangle t with t * samples / triangles == s, in whole numbers.
struct Sampling {
  std::uint32_t samples = 0, triangles = 0;

  DCM_HD bool isSample(std::uint32_t t) const { return scaled(t) % triangles < samples; }
  // Returns the number of a triangle that is a sample.
  DCM_HD std::uint32_t sampleOf(std::uint32_t t) const {
    return static_cast<std::uint32_t>(scaled(t) / triangles);
  }
  // Returns the triangle of a sample: sampleOf(triangleOf(s)) == s.
  DCM_HD std::uint32_t triangleOf(std::uint32_t sample) const {
    return static_cast<std::uint32_t>((std::uint64_t{sample} * triangles + samples - 1) / samples);
  }

 private:
  DCM_HD std::uint64_t scaled(std::uint32_t t) const { return std::uint64_t{t} * samples; }
};

// Returns a sampling with eight samples a cluster, at least `least`, and never more than there are
// triangles.
inline Sampling samplingOf(std::uint32_t triangles, std::uint32_t clusters, std::uint32_t least) {
  return {std::min(triangles, std::max(least, 8 * clusters)), triangles};
}

// Returns which triangle's centroid prototype `g` of `clusters` starts from: the one in the middle
// of its part of the order.
DCM_HD inline std::size_t seedOf(std::size_t g, std::size_t clusters, std::size_t triangles) {
  return (2 * g + 1) * triangles / (2 * clusters);
}

// The powers for the fuzzifier m: w = (d_min^2 / d^2)^(1 / (m - 1)) and u^m.
struct FuzzyPowers {
  float m = 2;

  // `ratio` in [0, 1].
  DCM_HD float weight(float ratio) const { return powf(ratio, 1 / (m - 1)); }
  // `u` in [0, 1].
  DCM_HD float power(float u) const { return powf(u, m); }
};

}  // namespace deformable_contact_monitor
