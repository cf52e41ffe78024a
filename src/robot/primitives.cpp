// Makes the triangles of URDF's primitives: box, cylinder, sphere.
#include "robot/primitives.h"

#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint32_t kCylinderSides = 64;
constexpr int kSphereDivisions = 3;

// Throws std::invalid_argument, which names the length, if it is not finite and greater than zero.
void requirePositive(double size_m, const char* what) {
  if (std::isfinite(size_m) && size_m > 0) return;
  std::ostringstream text;
  text << what << " is " << size_m << ", but must be a finite length greater than zero";
  throw std::invalid_argument(text.str());
}

// Returns the regular icosahedron whose vertices are on the unit sphere. Its vertices are the
// corners of three rectangles whose sides have the golden ratio g.
SourceMesh makeIcosahedron() {
  const double g = (1 + std::sqrt(5.0)) / 2;
  SourceMesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex.normalize();
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  return mesh;
}

// Divides every triangle of the unit sphere into four and moves the edges' midpoints onto the
// sphere. Both triangles at an edge use the same midpoint, so the mesh stays closed.
SourceMesh divide(const SourceMesh& coarse) {
  SourceMesh fine;
  fine.vertices = coarse.vertices;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto next = static_cast<std::uint32_t>(fine.vertices.size());
    const auto [entry, is_new] = middles.emplace(std::minmax(a, b), next);
    if (is_new) fine.vertices.push_back((fine.vertices[a] + fine.vertices[b]).normalized());
    return entry->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.triangles.insert(fine.triangles.end(),
                          {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

}  // namespace

SourceMesh makeBox(const Eigen::Vector3d& size_m) {
  requirePositive(size_m.x(), "box size x");
  requirePositive(size_m.y(), "box size y");
  requirePositive(size_m.z(), "box size z");
  SourceMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {  // bits 0, 1, 2: the positive side of x, y, z
    const Eigen::Vector3d side((corner & 1) - 0.5, (corner >> 1 & 1) - 0.5, (corner >> 2) - 0.5);
    mesh.vertices.push_back(size_m.cwiseProduct(side));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

SourceMesh makeCylinder(double radius_m, double length_m) {
  requirePositive(radius_m, "cylinder radius");
  requirePositive(length_m, "cylinder length");
  SourceMesh mesh;
  for (std::uint32_t side = 0; side < kCylinderSides; ++side) {
    const double angle = 2 * kPi * side / kCylinderSides;
    const double x = radius_m * std::cos(angle), y = radius_m * std::sin(angle);
    mesh.vertices.emplace_back(x, y, -length_m / 2);
    mesh.vertices.emplace_back(x, y, length_m / 2);
  }
  // The centres of the caps come after the vertices of the sides.
  const std::uint32_t bottom = 2 * kCylinderSides, top = bottom + 1;
  mesh.vertices.emplace_back(0, 0, -length_m / 2);
  mesh.vertices.emplace_back(0, 0, length_m / 2);
  for (std::uint32_t side = 0; side < kCylinderSides; ++side) {
    const std::uint32_t low = 2 * side, high = low + 1;
    const std::uint32_t next_low = 2 * ((side + 1) % kCylinderSides), next_high = next_low + 1;
    mesh.triangles.insert(mesh.triangles.end(), {{low, next_low, next_high},
                                                 {low, next_high, high},
                                                 {bottom, next_low, low},
                                                 {top, high, next_high}});
  }
  return mesh;
}

SourceMesh makeSphere(double radius_m) {
  requirePositive(radius_m, "sphere radius");
  SourceMesh mesh = makeIcosahedron();
  for (int i = 0; i < kSphereDivisions; ++i) mesh = divide(mesh);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= radius_m;
  return mesh;
}

}  // namespace deformable_contact_monitor
