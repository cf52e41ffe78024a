// Detectors that tests and benchmarks compare the backends with. They share no filter, no sweep and
// no clusters with these.
#pragma once

#include <memory>

#include "core/detector.h"

namespace deformable_contact_monitor {

// Returns a slow and simple detector that compares every pair of triangles with the same
// predicates, margins and pads, for discrete and continuous detection. It ignores `tolerance_m`. It
// uses one thread, and its time grows with the product of the triangle counts. Nearest pairs come
// from a loop over all pairs of triangles too. The vertices of bodies must be on the host.
std::unique_ptr<Detector> makeBruteForceDetector();

// Returns a detector that uses the bounding volume hierarchies of FCL (the Flexible Collision
// Library); only in a build with DCM_HAVE_FCL. Its triangle test works in floating point, so that
// its pairs may differ from the exact ones (`guaranteed` is always false). It cannot tell whether
// triangles that share a vertex meet beyond it, so that it leaves out such pairs for all values of
// `adjacent`. It lists no near pairs: all separations are 0. The distances of nearest pairs are
// right to about 1e-6 of themselves, and of several pairs at the same distance it takes any. It
// uses one thread.
std::unique_ptr<Detector> makeFclDetector();

}  // namespace deformable_contact_monitor
