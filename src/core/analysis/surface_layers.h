// Finds the closed surfaces of a component in which more than two triangles share an edge.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"

namespace deformable_contact_monitor {

// A triangle with three different vertices.
struct SurfaceTriangle {
  std::array<std::uint32_t, 3> corners;  // numbers of vertices; equal points have equal numbers
  std::uint32_t index = 0;               // in the mesh
};

// The closed surfaces of a component, called layers. A layer is a set of triangles of which each
// edge has an even number, so a ray from a point that is enclosed by it crosses it an odd number of
// times.
//
// Many exporters write a surface twice, once for each side. So copies are recognised. Triangles
// with the same three vertices, in either orientation, are copies of each other. A patch is a set
// of triangles that are connected by edges of exactly two of them, where copies count as one. Two
// patches with the same vertices and the same outline are copies too: they are a polygon that was
// divided in two ways. A patch is there as often as the rarest of its triangles.
//
// There are three kinds of layers:
// - all triangles as often as they are there;
// - one copy of every patch;
// - for each k, one copy of the patches whose number of copies has bit k. In a mesh of two boxes
//   that share a wall, each written twice, the wall is there four times. Then bit 1 tells the
//   hull of both boxes.
struct SurfaceLayers {
  // At least one layer is not empty, and each patch whose number of copies is odd is in one.
  bool closed = false;
  // For each triangle, in the order of the argument, a bit for each layer that it is in.
  std::vector<std::uint32_t> of;
};

// Returns the layers of the triangles of one component. If the limit is over, the result means
// nothing.
SurfaceLayers findLayers(const std::vector<SurfaceTriangle>& triangles, const CycleLimit& limit);

}  // namespace deformable_contact_monitor
