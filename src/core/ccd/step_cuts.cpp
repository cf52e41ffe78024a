#include "core/ccd/step_cuts.h"

#include <algorithm>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

struct Cuts {
  std::vector<double> at;  // up to where there were too many
  double pieces = 0;
};

// Of the bends after `i` a far one that is within the tolerance; the next one if none is. By
// doubling and halving the distance.
std::size_t farthestBend(const std::vector<double>& bends, const DeviationBetween& deviation,
                         double tolerance, std::size_t i) {
  const auto isWithin = [&](std::size_t j) {
    return j < bends.size() && deviation(bends[i], bends[j]) <= tolerance;
  };
  std::size_t j = i + 1, more = 1;
  for (; isWithin(j + more); more *= 2) j += more;
  for (more /= 2; more > 0; more /= 2) {
    if (isWithin(j + more)) j += more;
  }
  return j;
}

// From the left, ever as far as the tolerance lets: over several bends, or over a part of an arc.
Cuts cutsWithin(const std::vector<double>& bends, const DeviationBetween& deviation,
                double tolerance, int most) {
  Cuts cuts{{0}, 0};
  for (std::size_t i = 0; i + 1 < bends.size();) {
    const std::size_t j = farthestBend(bends, deviation, tolerance, i);
    double parts = 1;
    if (j == i + 1) {
      parts = std::ceil(std::sqrt(deviation(bends[i], bends[j]) / tolerance));
      parts = std::max(parts, 1.0);
    }
    cuts.pieces += parts;
    for (int k = 1; k < parts && cuts.pieces <= most; ++k) {
      cuts.at.push_back(bends[i] + (bends[j] - bends[i]) * (k / parts));
    }
    cuts.at.push_back(bends[j]);
    i = j;
  }
  return cuts;
}

}  // namespace

std::vector<double> cutStep(const std::vector<double>& bends, const DeviationBetween& deviation,
                            double tolerance, int most) {
  Cuts cuts = cutsWithin(bends, deviation, tolerance, most);
  while (cuts.pieces > most) {
    const double ratio = std::min(cuts.pieces / most, 1e100);
    tolerance *= std::max(ratio * ratio, 1.05);
    cuts = cutsWithin(bends, deviation, tolerance, most);
  }
  return cuts.at;
}

}  // namespace deformable_contact_monitor
