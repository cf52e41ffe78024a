// Seeded random scenes on which touching, coplanar, degenerate and extreme triangles are common.
#pragma once

#include <cstdint>

#include "core/scene.h"

namespace deformable_contact_monitor {

// The same seed gives the same scene on every machine. Up to four bodies of up to 40 triangles in
// all, on small-integer grids or off them, at scales from 1e-40 to 1e30, with duplicates, needles,
// huge and non-finite triangles, negative zeros, shared vertices by index and by coordinates,
// random poses and random enabled pairs.
Scene randomScene(std::uint32_t seed);

// Two bodies of 1 500 small triangles each and a few huge ones, in a box, on a fine grid or off it;
// every pair is enabled.
Scene largeRandomScene(std::uint32_t seed);

}  // namespace deformable_contact_monitor
