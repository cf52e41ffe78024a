// The primitives of URDF as triangles.
#pragma once

#include <Eigen/Core>

#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

// All of them are centred at the origin, closed (every edge belongs to two triangles, once in each
// direction) and wound counter-clockwise seen from outside. Vertices lie on the true surface, so
// curved surfaces are approached from within. They throw std::invalid_argument, naming the size, if
// one is not finite and greater than zero.

// 8 vertices, 12 triangles.
SourceMesh makeBox(const Eigen::Vector3d& size_m);

// Around the z axis: 64 sides, each cap fanned from its centre; 256 triangles. The surface is off
// by at most 0.13 % of the radius.
SourceMesh makeCylinder(double radius_m, double length_m);

// An icosahedron divided three times; 642 vertices, 1280 triangles. The surface is off by at most
// 0.5 % of the radius.
SourceMesh makeSphere(double radius_m);

}  // namespace deformable_contact_monitor
