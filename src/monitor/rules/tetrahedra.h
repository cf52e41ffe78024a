// The surface of a mesh of tetrahedra, whose cells are in a file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace deformable_contact_monitor {

// Triangles whose vertices are the points of a cloud.
struct PointTriangles {
  std::size_t point_count = 0;
  std::vector<std::uint32_t> triangles;  // three indices each, all below point_count
};

// A tetrahedron: the indices of its corners, and the line of the file that has it.
struct Cell {
  std::array<std::uint32_t, 4> corners;
  std::uint32_t line;
};

constexpr std::size_t kMostTetrahedra = std::size_t{1} << 24;

// Reads one cell per line: four point indices, counted from 0, with blanks or a comma between them.
// Lines that are empty or begin with '#' are left out. Throws std::runtime_error, with the line,
// for any other line, for a cell that has a corner twice, for more than kMostTetrahedra, and if
// there is no cell.
std::vector<Cell> readCells(std::string_view text);

// Returns the faces that belong to exactly one cell, in the order of the cells. There are as many
// points as the highest index says. The faces of a cell (a, b, c, d) are (b, c, d), (a, d, c),
// (a, b, d) and (a, c, b), in this order. They point outwards if d is on the side of the triangle
// (a, b, c) from which a, b and c run counterclockwise. Throws std::runtime_error, with the lines,
// if two cells have the same corners, if more than two cells have a face, and if there is no such
// face.
PointTriangles surfaceOf(const std::vector<Cell>& cells);

}  // namespace deformable_contact_monitor
