// Where a step is cut into sub-steps.
#pragma once

#include <functional>
#include <vector>

namespace deformable_contact_monitor {

// The largest deviation [m] of any point from its straight line in [from, to].
using DeviationBetween = std::function<double(double from, double to)>;

// Ascending parts of the step, from 0 to 1, between which no point deviates by more than
// `tolerance` [m], or, were that more than `most` pieces, a larger one that is enough. `bends`:
// ascending, from 0 to 1; between two of them every point moves evenly, on an arc, of which an nth
// part deviates by an nth of an nth.
std::vector<double> cutStep(const std::vector<double>& bends, const DeviationBetween& deviation,
                            double tolerance, int most);

}  // namespace deformable_contact_monitor
