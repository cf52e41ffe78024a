// Finds the surface of a mesh of tetrahedra: all faces are sorted, so that equal ones stand side by
// side. This needs no points, so a surface is found once and holds however the mesh deforms.
#include "monitor/rules/tetrahedra.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <stdexcept>
#include <system_error>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kFaces = 4;
constexpr std::uint32_t kMostIndex = std::numeric_limits<std::int32_t>::max() - 1;

// Corners of the faces, by their places in the cell. Face i lacks corner i.
constexpr std::size_t kCorners[kFaces][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

// A face with ascending corners, so that those of two cells compare equal.
struct Face {
  std::array<std::uint32_t, 3> corners;
  std::uint32_t number;  // kFaces times its cell, plus its place in it
};

std::string lineText(std::size_t line) { return "line " + std::to_string(line); }

// Reads an index from the beginning of *rest, and removes it with what parts it from the next.
// Returns false if there is none.
bool readIndex(std::string_view* rest, std::uint32_t* index) {
  const char* const begin = rest->data();
  const auto [end, error] = std::from_chars(begin, begin + rest->size(), *index);
  if (error != std::errc() || *index > kMostIndex) return false;
  rest->remove_prefix(static_cast<std::size_t>(end - begin));
  const std::size_t gap = std::min(rest->find_first_not_of(" \t,"), rest->size());
  rest->remove_prefix(gap);
  return gap > 0 || rest->empty();
}

Cell readCell(std::string_view text, std::size_t line) {
  Cell cell{{}, static_cast<std::uint32_t>(line)};
  std::string_view rest = text;
  bool is_cell = true;
  for (std::uint32_t& corner : cell.corners) is_cell = is_cell && readIndex(&rest, &corner);
  if (!is_cell || !rest.empty()) {
    throw std::runtime_error(lineText(line) + " is '" + std::string(text.substr(0, 40)) +
                             "', must be the four point indices of a cell");
  }
  auto sorted = cell.corners;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    throw std::runtime_error(lineText(line) + " has point " + std::to_string(*twice) +
                             " twice, so the cell is empty");
  }
  return cell;
}

std::vector<Face> sortedFaces(const std::vector<Cell>& cells) {
  std::vector<Face> faces;
  faces.reserve(kFaces * cells.size());
  for (const Cell& cell : cells) {
    for (const auto& places : kCorners) {
      Face face{{cell.corners[places[0]], cell.corners[places[1]], cell.corners[places[2]]},
                static_cast<std::uint32_t>(faces.size())};
      std::sort(face.corners.begin(), face.corners.end());
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.number < b.number;
  });
  return faces;
}

// Checks the cells that share a face, which are those of `faces` in [first, end).
void checkNeighbours(const std::vector<Cell>& cells, const std::vector<Face>& faces,
                     std::size_t first, std::size_t end) {
  const auto cellOf = [&](std::size_t i) -> const Cell& { return cells[faces[i].number / kFaces]; };
  const auto farCorner = [&](std::size_t i) { return cellOf(i).corners[faces[i].number % kFaces]; };
  for (std::size_t i = first + 1; i < end; ++i) {
    if (farCorner(i) == farCorner(i - 1)) {
      throw std::runtime_error(lineText(cellOf(i - 1).line) + " and " + lineText(cellOf(i).line) +
                               " are the same cell");
    }
  }
  if (end - first <= 2) return;
  const auto& corners = faces[first].corners;
  std::string lines = lineText(cellOf(first).line);
  for (std::size_t i = first + 1; i < first + 3; ++i) lines += ", " + lineText(cellOf(i).line);
  throw std::runtime_error(lines + ": the face " + std::to_string(corners[0]) + " " +
                           std::to_string(corners[1]) + " " + std::to_string(corners[2]) +
                           " belongs to " + std::to_string(end - first) +
                           " cells, must be at most two");
}

}  // namespace

std::vector<Cell> readCells(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<Cell> cells;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view content = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    content.remove_prefix(std::min(content.find_first_not_of(kBlanks), content.size()));
    content.remove_suffix(content.size() - (content.find_last_not_of(kBlanks) + 1));
    if (content.empty() || content.front() == '#') continue;
    if (cells.size() == kMostTetrahedra) {
      throw std::runtime_error("there are more than " + std::to_string(kMostTetrahedra) + " cells");
    }
    cells.push_back(readCell(content, line));
  }
  if (cells.empty()) throw std::runtime_error("there is no cell");
  return cells;
}

PointTriangles surfaceOf(const std::vector<Cell>& cells) {
  const std::vector<Face> faces = sortedFaces(cells);
  std::vector<std::uint32_t> outer;  // numbers of faces of one cell
  for (std::size_t first = 0, end = 0; first < faces.size(); first = end) {
    while (end < faces.size() && faces[end].corners == faces[first].corners) ++end;
    checkNeighbours(cells, faces, first, end);
    if (end - first == 1) outer.push_back(faces[first].number);
  }
  if (outer.empty()) throw std::runtime_error("the cells have no surface");
  std::sort(outer.begin(), outer.end());
  PointTriangles surface;
  surface.triangles.reserve(3 * outer.size());
  for (const std::uint32_t number : outer) {
    const auto& corners = cells[number / kFaces].corners;
    for (const std::size_t place : kCorners[number % kFaces]) {
      surface.triangles.push_back(corners[place]);
    }
  }
  for (const Cell& cell : cells) {
    const std::size_t highest = *std::max_element(cell.corners.begin(), cell.corners.end());
    surface.point_count = std::max(surface.point_count, highest + 1);
  }
  return surface;
}

}  // namespace deformable_contact_monitor
