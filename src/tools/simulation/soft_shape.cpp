// The soft object that a simulation starts with.
#include "tools/simulation/soft_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>
#include <utility>

#include "core/mesh_file.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kUnevenness = 0.02;        // of the distance of neighbours
constexpr double kPinnedHeight = 0.05;      // of the height of a volume or a file
constexpr std::size_t kMostNodes = 100000;  // more are not simulated in any useful time

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// Returns numbers in [-0.5, 0.5). std::mt19937's numbers are the same everywhere; the standard's
// distributions are not.
class Unevenness {
 public:
  explicit Unevenness(std::uint32_t seed) : random_(seed) {}
  double next() { return random_() / 4294967296.0 - 0.5; }

 private:
  std::mt19937 random_;
};

// Makes a square grid with springs along it, across its cells, and to the second neighbours, which
// resist bending. The order runs from the first edge downwards, so that one pass carries the hold
// of that edge through the whole sheet.
SoftShape clothShape(const SoftShapeOptions& o) {
  SoftShape shape;
  const int cells = std::max(1, static_cast<int>(std::lround(std::sqrt(o.vertices))) - 1);
  const double spacing = o.size_m / cells;
  Unevenness uneven(o.seed);
  const auto at = [&](int row, int column) {
    return static_cast<std::uint32_t>(row * (cells + 1) + column);
  };
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column) {
      const double z = row == 0 ? 0 : kUnevenness * uneven.next();
      shape.nodes.push_back(o.offset + spacing * Eigen::Vector3d(-row, column - cells / 2.0, z));
      const std::uint32_t here = at(row, column);
      if (row > 0) shape.springs.push_back({at(row - 1, column), here});
      if (column > 0) shape.springs.push_back({at(row, column - 1), here});
      if (row > 0 && column > 0) {
        shape.springs.push_back({at(row - 1, column - 1), here});
        shape.springs.push_back({at(row - 1, column), at(row, column - 1)});
        const std::array<std::uint32_t, 6> triangles = {
            at(row - 1, column - 1), at(row, column - 1), at(row - 1, column),
            at(row - 1, column),     at(row, column - 1), here};
        shape.triangles.insert(shape.triangles.end(), triangles.begin(), triangles.end());
      }
      if (row > 1) shape.springs.push_back({at(row - 2, column), here, true});
      if (column > 1) shape.springs.push_back({at(row, column - 2), here, true});
    }
  }
  if (o.pinned == "edge") {
    for (int column = 0; column <= cells; ++column) shape.pinned.push_back(at(0, column));
  } else if (o.pinned == "corners") {
    shape.pinned = {at(0, 0), at(0, cells), at(cells, 0), at(cells, cells)};
  }
  return shape;
}

// Makes a chain of nodes.
SoftShape ropeShape(const SoftShapeOptions& o) {
  SoftShape shape;
  shape.is_rope = true;
  const int segments = std::max(1, o.vertices - 1);
  const double spacing = o.size_m / segments;
  Unevenness uneven(o.seed);
  for (int i = 0; i <= segments; ++i) {
    const auto here = static_cast<std::uint32_t>(i);
    const double y = i == 0 ? 0 : kUnevenness * uneven.next();
    const double z = i == 0 ? 0 : kUnevenness * uneven.next();
    shape.nodes.push_back(o.offset + spacing * Eigen::Vector3d(-i, y, z));
    if (i > 0) {
      shape.springs.push_back({here - 1, here});
      shape.triangles.insert(shape.triangles.end(), {here - 1, here, here});
    }
    if (i > 1) shape.springs.push_back({here - 2, here, true});
  }
  if (o.pinned == "edge") shape.pinned = {0};
  if (o.pinned == "corners") shape.pinned = {0, static_cast<std::uint32_t>(segments)};
  return shape;
}

// Adds a spring for each edge of the triangles, and one between the two vertices that face each
// other across an edge. Returns whether each edge has exactly two triangles.
bool addSpringsOfTriangles(SoftShape* shape) {
  std::map<Edge, std::vector<std::uint32_t>> opposite;  // by edge, lower node first
  for (std::size_t t = 0; t < shape->triangles.size(); t += 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = shape->triangles[t + i], b = shape->triangles[t + (i + 1) % 3];
      if (a != b) {
        opposite[std::minmax(a, b)].push_back(shape->triangles[t + (i + 2) % 3]);
      }
    }
  }
  bool closed = true;
  for (const auto& [edge, others] : opposite) {
    shape->springs.push_back({edge.first, edge.second});
    closed &= others.size() == 2;
  }
  for (const auto& [edge, others] : opposite) {
    if (others.size() != 2 || others[0] == others[1]) continue;
    if (opposite.count(std::minmax(others[0], others[1])) > 0) continue;
    shape->springs.push_back({others[0], others[1], true});
  }
  return closed;
}

// Pins the nodes in the lowest or highest part of the height.
void pinByHeight(bool lowest, SoftShape* shape) {
  double low = shape->nodes.front().z(), high = low;
  for (const Eigen::Vector3d& node : shape->nodes) {
    low = std::min(low, node.z());
    high = std::max(high, node.z());
  }
  const double part = kPinnedHeight * (high - low);
  for (std::size_t i = 0; i < shape->nodes.size(); ++i) {
    const double z = shape->nodes[i].z();
    if (lowest ? z <= low + part : z >= high - part) {
      shape->pinned.push_back(static_cast<std::uint32_t>(i));
    }
  }
}

void refuseCorners(const SoftShapeOptions& o) {
  if (o.pinned != "corners") return;
  throw std::invalid_argument("only a cloth and a rope have corners to pin; give edge or none");
}

// Makes a ball of rings between two poles, whose rings have as many nodes as two meridians.
SoftShape volumeShape(const SoftShapeOptions& o) {
  refuseCorners(o);
  SoftShape shape;
  const int rings = std::max(3, static_cast<int>(std::lround(std::sqrt(o.vertices / 2.0))));
  const int around = 2 * rings;
  const double pi = std::acos(-1.0);
  Unevenness uneven(o.seed);
  shape.nodes.emplace_back(o.offset - Eigen::Vector3d(0, 0, o.size_m / 2));
  for (int ring = 1; ring <= rings; ++ring) {
    for (int i = 0; i < around; ++i) {
      const double down = pi * ring / (rings + 1), angle = 2 * pi * (i + 0.5 * (ring % 2)) / around;
      const double radius = o.size_m / 2 * (1 + kUnevenness / rings * uneven.next());
      shape.nodes.emplace_back(o.offset + radius * Eigen::Vector3d(std::sin(down) * std::cos(angle),
                                                                   std::sin(down) * std::sin(angle),
                                                                   -std::cos(down)));
    }
  }
  shape.nodes.emplace_back(o.offset + Eigen::Vector3d(0, 0, o.size_m / 2));
  const auto at = [&](int ring, int i) {
    if (ring == 0) return std::uint32_t{0};
    if (ring > rings) return static_cast<std::uint32_t>(rings * around + 1);
    return static_cast<std::uint32_t>(1 + (ring - 1) * around + (i + around) % around);
  };
  for (int ring = 0; ring <= rings; ++ring) {
    for (int i = 0; i < around; ++i) {
      // Odd rings are turned by half a cell, so the diagonals alternate.
      const int shift = ring % 2;
      if (ring < rings) {
        shape.triangles.insert(shape.triangles.end(),
                               {at(ring, i + 1 - shift), at(ring + 1, i + 1), at(ring + 1, i)});
      }
      if (ring > 0) {
        shape.triangles.insert(shape.triangles.end(),
                               {at(ring, i), at(ring, i + 1), at(ring + 1, i + shift)});
      }
    }
  }
  shape.is_volume = addSpringsOfTriangles(&shape);
  if (o.pinned == "edge") pinByHeight(true, &shape);
  return shape;
}

// Reads a mesh file. Vertices with equal coordinates become one node.
SoftShape fileShape(const SoftShapeOptions& o) {
  refuseCorners(o);
  const TriangleMesh mesh = readMeshFile(o.object);
  SoftShape shape;
  std::map<std::array<float, 3>, std::uint32_t> node_at;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    const std::array<float, 3> place = {mesh.vertices[i], mesh.vertices[i + 1],
                                        mesh.vertices[i + 2]};
    const Eigen::Vector3d p(place[0], place[1], place[2]);
    if (!p.allFinite()) throw std::invalid_argument(o.object + ": has a vertex that is not finite");
    const auto [found, is_new] =
        node_at.emplace(place, static_cast<std::uint32_t>(shape.nodes.size()));
    if (is_new) shape.nodes.emplace_back(o.size_m * p + o.offset);
    shape.node_of_vertex.push_back(found->second);
  }
  if (shape.nodes.size() > kMostNodes) {
    throw std::invalid_argument(o.object + ": has " + std::to_string(shape.nodes.size()) +
                                " vertices, but at most " + std::to_string(kMostNodes) +
                                " are simulated");
  }
  shape.mesh_triangles.assign(mesh.triangles.begin(), mesh.triangles.end());
  std::vector<bool> used(shape.nodes.size());
  for (const std::uint32_t vertex : shape.mesh_triangles) {
    shape.triangles.push_back(shape.node_of_vertex[vertex]);
    used[shape.triangles.back()] = true;
  }
  shape.is_volume = addSpringsOfTriangles(&shape);
  if (o.pinned == "edge") pinByHeight(shape.is_volume, &shape);
  // A vertex without triangles would fall alone.
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) shape.pinned.push_back(static_cast<std::uint32_t>(i));
  }
  std::sort(shape.pinned.begin(), shape.pinned.end());
  shape.pinned.erase(std::unique(shape.pinned.begin(), shape.pinned.end()), shape.pinned.end());
  return shape;
}

}  // namespace

SoftShape softShape(const SoftShapeOptions& o) {
  if (o.vertices < 2 || !(o.size_m > 0) || !std::isfinite(o.size_m) || !o.offset.allFinite()) {
    throw std::invalid_argument(
        "a soft object needs two vertices, a finite place and a finite size above zero");
  }
  if (o.pinned != "edge" && o.pinned != "corners" && o.pinned != "none") {
    throw std::invalid_argument("'" + o.pinned + "' is not one of edge, corners, none");
  }
  SoftShape shape;
  if (o.object == "cloth") {
    shape = clothShape(o);
  } else if (o.object == "rope") {
    shape = ropeShape(o);
  } else if (o.object == "volume") {
    shape = volumeShape(o);
  } else {
    return fileShape(o);
  }
  for (std::uint32_t i = 0; i < shape.nodes.size(); ++i) shape.node_of_vertex.push_back(i);
  shape.mesh_triangles = shape.triangles;
  return shape;
}

}  // namespace deformable_contact_monitor
