// Polygons with integer corners, their OBJ files, and an exact oracle of their triangles: areas,
// and in how many triangles sample points are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

struct Point {
  std::int64_t x = 0, y = 0;
};
using Polygon = std::vector<Point>;
using Triangles = std::vector<Polygon>;

bool operator==(const Point& a, const Point& b);

// Positive if the corners are in counter-clockwise order.
std::int64_t doubledArea(const Polygon& polygon);

// Returns whether the sides ab and cd have a point in common.
bool sidesMeet(const Point& a, const Point& b, const Point& c, const Point& d);

// Where the plane of the polygon is: a point is u x + v y + offset, exact in float32.
struct Plane {
  std::array<int, 3> u = {1, 0, 0}, v = {0, 1, 0}, offset = {0, 0, 0};
  double unit = 1;  // a power of two
};
extern const std::vector<Plane> kPlanes;

// Returns an OBJ file of the polygon, from corner `start` on.
std::string objOf(const Polygon& polygon, const Plane& plane, std::size_t start);

TriangleMesh readObjText(const std::string& text, std::vector<std::string>* notes);

// Returns what the reader makes of the polygon. Fails the test if there is a note.
Triangles trianglesOf(const Polygon& polygon, const Plane& plane, std::size_t start);

// The triangles' areas add up to the polygon's, and sample points are in one triangle if they are
// in the polygon, and else in none. Points on sides are left out.
void expectCovers(const Triangles& triangles, const Polygon& polygon, int samples);

// Expects that the triangles are the polygon in every plane, from some corners, and the other way
// round.
void expectTriangulated(Polygon polygon, int samples = 200);

// Returns the triangles of a fan from corner 0, by its corners' indices.
std::vector<std::uint32_t> fanOf(std::uint32_t size);

}  // namespace deformable_contact_monitor
