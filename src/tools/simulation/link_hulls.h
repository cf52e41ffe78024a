// The convex pieces of a link's mesh, as shapes of Bullet.
#pragma once

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>

#include <memory>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

// Returns the convex hull of each connected part of the mesh; vertices with equal coordinates
// connect. Vertices that are not finite are left out, and so are their triangles. The shapes have
// no margin.
std::vector<std::unique_ptr<btConvexHullShape>> linkHulls(const TriangleMesh& mesh);

}  // namespace deformable_contact_monitor
