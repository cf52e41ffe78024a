// Which triangles stand for the scene in fuzzy c-means, and where prototypes start.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// `samples` of `triangles` triangles, 0 < samples <= triangles, evenly spread over their order.
// Sample s is the first triangle t with t * samples / triangles == s, in whole numbers.
struct Sampling {
  std::uint32_t samples = 0, triangles = 0;

  DCM_HD bool isSample(std::uint32_t t) const { return scaled(t) % triangles < samples; }
  // Of a triangle that is one.
  DCM_HD std::uint32_t sampleOf(std::uint32_t t) const {
    return static_cast<std::uint32_t>(scaled(t) / triangles);
  }
  // The inverse: sampleOf(triangleOf(s)) == s.
  DCM_HD std::uint32_t triangleOf(std::uint32_t sample) const {
    return static_cast<std::uint32_t>((std::uint64_t{sample} * triangles + samples - 1) / samples);
  }

 private:
  DCM_HD std::uint64_t scaled(std::uint32_t t) const { return std::uint64_t{t} * samples; }
};

// Eight a cluster, `least` at least; never more than there are triangles.
inline Sampling samplingOf(std::uint32_t triangles, std::uint32_t clusters, std::uint32_t least) {
  return {std::min(triangles, std::max(least, 8 * clusters)), triangles};
}

// Where in the order of `triangles` triangles the centroid lies that prototype `g` of `clusters`
// starts from: in the middle of its share.
DCM_HD inline std::size_t seedOf(std::size_t g, std::size_t clusters, std::size_t triangles) {
  return (2 * g + 1) * triangles / (2 * clusters);
}

}  // namespace deformable_contact_monitor
