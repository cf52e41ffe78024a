// Points of exact rationals, for the oracles.
#pragma once

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace exact {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Rational = Kernel::FT;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;

inline Point toPoint(const Vec3f& v) { return {double{v.x}, double{v.y}, double{v.z}}; }

}  // namespace exact
}  // namespace deformable_contact_monitor
