// Builders of scenes and meshes for the tests.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/predicates/triangle.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Triangles with vertices of their own, none shared by index.
TriangleMesh meshOf(const std::vector<Triangle>& triangles);

// The same triangles in the same order, none sharing a vertex by index.
TriangleMesh soupOf(const TriangleMesh& mesh);

// A square cloth of 2 n n triangles, [0, side] x [0, side] in the plane z = height, with waves of
// the given height.
TriangleMesh clothGrid(int n, float side, float height, float wave_height);

// Every triangle as nine, by thirds of its edges; neighbours still fit.
TriangleMesh splitThreeByThree(const TriangleMesh& mesh);

// Copies of the mesh side by side, apart, until there are at least `triangles` of them; or the
// first `triangles` of it.
TriangleMesh sizedTo(const TriangleMesh& mesh, std::size_t triangles);

// Slivers of 1 m along x or y (0, 1), so many in each layer; layers of the two soups lie in turn,
// the given gap apart. All boxes of groups of them overlap, and none touches one of the other soup.
TriangleMesh sliverSoup(int along, int layers, int in_layer, float gap_m);

// One body, looked at for contacts with itself.
Scene selfScene(TriangleMesh mesh);

// Two bodies, looked at for contacts of each with the other.
Scene pairScene(TriangleMesh a, TriangleMesh b);

}  // namespace deformable_contact_monitor
