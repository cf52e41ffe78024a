// Other ways to decide states of a robot, which measure_trade --states compares ours with.
#pragma once

#include <cstddef>
#include <memory>

#include "core/state_checker.h"

namespace deformable_contact_monitor {

// Returns a checker that uses FCL (the Flexible Collision Library), one thread: a bounding volume
// hierarchy of each body is built once and kept, and each pair of bodies is collided up to the
// first contact. It knows only whether a state touches, of bodies whose triangles are all finite
// and whose poses are rigid, without parts and radii. Its triangle test works in floating point.
// Null in a build without FCL.
std::unique_ptr<StateChecker> makeFclStateChecker();

// How large the spheres of a link are.
enum class SphereSize {
  kCovering,  // they cover the link
  kMean,      // as far from its centre as the sphere's vertices on average
};

// Returns a checker that takes spheres in place of the moved bodies, as planners usually do: so
// many for each, around groups of its triangles. Whether a sphere touches the other bodies'
// triangles is decided exactly, on one thread.
std::unique_ptr<StateChecker> makeSphereStateChecker(std::size_t spheres_per_body, SphereSize size);

}  // namespace deformable_contact_monitor
