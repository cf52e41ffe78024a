// Makes triangle meshes of the primitives of URDF [m].
#pragma once

#include <Eigen/Core>

#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

// All meshes are centred at the origin, closed (every edge belongs to two triangles, once in each
// direction) and wound counter-clockwise seen from outside. Vertices lie on the true surface, so a
// curved surface contains its mesh. The functions throw std::invalid_argument, naming the size, if
// a size is not finite and greater than zero.

// Returns a box whose edges, of these lengths, are along the axes. It has 8 vertices and 12
// triangles.
SourceMesh makeBox(const Eigen::Vector3d& size_m);

// Returns a cylinder along z with 64 sides, and caps that are fans around their centres. It has 256
// triangles. The mesh is at most 0.13 % of the radius inside the true surface.
SourceMesh makeCylinder(double radius_m, double length_m);

// Returns an icosahedron whose triangles are divided three times. It has 642 vertices and 1280
// triangles. The mesh is at most 0.5 % of the radius inside the true surface.
SourceMesh makeSphere(double radius_m);

}  // namespace deformable_contact_monitor
