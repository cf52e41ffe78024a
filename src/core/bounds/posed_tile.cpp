// Makes a tile of a body in the scene frame. In most tiles all vertices are finite, and the lists
// of the tiling are copied as they are. Otherwise the triangles with other vertices are left out.
//
// The gap of two oriented boxes is measured along the three axes of either box. These are six of
// the fifteen axes of the separating axis test (Gottschalk, Lin and Manocha: OBBTree, 1996). A
// lower bound is right without the other nine.
#include "core/bounds/posed_tile.h"

#include <algorithm>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

// Everything is computed in double from float32 points; u = 2^-53. Nothing overflows or underflows,
// because squares of differences of float32 numbers are between 1e-90 and 1e78. All slacks are many
// times larger than the rounding errors, and far below the sizes that matter.
//
// Axes. A normalised vector has length 1 within 3 u. Removing the part along the first axis twice
// leaves at most 4 u of it, because a vector that becomes shorter than kFlat times its length is
// not used. The third axis is the cross product of the first two. So all nine dot products of axes
// are right within kAxisError.
constexpr double kFlat = 1e-6;

// Half sizes. w = p - c has an error of u |w|; its dot product with an axis has an error of at most
// 5 u |w|. The axes are orthogonal within e = kAxisError, so the coordinates of w differ from its
// dot products with them by at most 4 e |w|. Moving the centre adds an error of 4 u (|c| + |w|).
constexpr double kBoxSlack = 1e-12;

// Gaps. The sums below have an error of at most 30 u times all lengths in them. If an axis is
// longer than 1 by e, box b reaches e farther along it.
constexpr double kGapSlack = 1e-12;

// Returns a number that is at least the length of v.
double sizeOf(const Vec3d& v) { return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z); }

// Scales a vector to length 1. Returns false if it has no direction.
bool normalise(Vec3d& v) {
  const double size = length(v);
  if (!(size > 0)) return false;
  v = v * (1 / size);
  return true;
}

// Returns some unit vector orthogonal to `axis`. It starts from the coordinate axis that is
// farthest from parallel to `axis`.
Vec3d across(const Vec3d& axis) {
  const double x = std::fabs(axis.x), y = std::fabs(axis.y), z = std::fabs(axis.z);
  Vec3d least{x <= y && x <= z ? 1.0 : 0.0, 0, 0};
  if (least.x == 0) (y <= z ? least.y : least.z) = 1;
  Vec3d other = cross(axis, least);
  normalise(other);
  return other;
}

// Returns a unit vector along the longest difference of a point from the first point, without its
// part along `normal`.
Vec3d widestAcross(const float* x, const float* y, const float* z, std::size_t count,
                   const Vec3d& normal) {
  Vec3d widest;
  double widest2 = 0;
  for (std::size_t i = 1; i < count; ++i) {
    const Vec3d d{static_cast<double>(x[i]) - x[0], static_cast<double>(y[i]) - y[0],
                  static_cast<double>(z[i]) - z[0]};
    const double length2 = dot(d, d);
    if (length2 > widest2) {
      widest = d;
      widest2 = length2;
    }
  }
  Vec3d along = widest - normal * dot(widest, normal);
  if (!(dot(along, along) > kFlat * kFlat * widest2)) return across(normal);
  along = along - normal * dot(along, normal);
  normalise(along);
  along = along - normal * dot(along, normal);
  normalise(along);
  return along;
}

// The range of points along an axis [m].
struct Extent {
  double low = INFINITY, high = -INFINITY;
};

// Returns the range of the points along an axis, relative to the point `from`. Four partial ranges
// let the compiler use vector instructions.
Extent extentAlong(const Vec3d& axis, const Vec3d& from, const float* x, const float* y,
                   const float* z, std::size_t count) {
  constexpr std::size_t kLanes = 4;
  double low[kLanes], high[kLanes];
  std::fill_n(low, kLanes, INFINITY);
  std::fill_n(high, kLanes, -INFINITY);
  const auto add = [&](std::size_t i, std::size_t k) {
    const double at =
        axis.x * (x[i] - from.x) + axis.y * (y[i] - from.y) + axis.z * (z[i] - from.z);
    low[k] = least(low[k], at);
    high[k] = most(high[k], at);
  };
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) add(i + k, k);
  }
  for (; i < count; ++i) add(i, 0);
  return {least(least(low[0], low[1]), least(low[2], low[3])),
          most(most(high[0], high[1]), most(high[2], high[3]))};
}

// Returns the sum of the squared gaps along a's axes [m^2]. `offset` is b's centre - a's centre.
double squaredGapAlong(const OrientedBox& a, const OrientedBox& b, const Vec3d& offset,
                       double slack) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double reach = a.half[i] + b.half[0] * std::fabs(dot(a.axis[i], b.axis[0])) +
                         b.half[1] * std::fabs(dot(a.axis[i], b.axis[1])) +
                         b.half[2] * std::fabs(dot(a.axis[i], b.axis[2]));
    const double gap = std::fabs(dot(a.axis[i], offset)) - reach - slack;
    sum += gap > 0 ? gap * gap : 0;
  }
  return sum;
}

}  // namespace

OrientedBox orientedBoxOf(const float* x, const float* y, const float* z, std::size_t count,
                          const Vec3d& normal) {
  OrientedBox box;
  box.axis[0] = normal;
  if (!normalise(box.axis[0])) box.axis[0] = {0, 0, 1};
  box.axis[1] = widestAcross(x, y, z, count, box.axis[0]);
  box.axis[2] = cross(box.axis[0], box.axis[1]);
  // Coordinates are taken relative to a point of the box, so that they keep their digits far from
  // the origin.
  const Vec3d from{x[0], y[0], z[0]};
  Extent extent[3];
  double reach = 0;
  for (int k = 0; k < 3; ++k) {
    extent[k] = extentAlong(box.axis[k], from, x, y, z, count);
    reach += most(-extent[k].low, extent[k].high);
  }
  box.centre = from;
  const double slack = kBoxSlack * (reach + sizeOf(from));
  for (int k = 0; k < 3; ++k) {
    box.centre = box.centre + box.axis[k] * ((extent[k].low + extent[k].high) / 2);
    box.half[k] = (extent[k].high - extent[k].low) / 2 + slack;
  }
  return box;
}

double lowerGap(const OrientedBox& a, const OrientedBox& b) {
  const Vec3d offset = b.centre - a.centre;
  const double slack = kGapSlack * (sizeOf(a.centre) + sizeOf(b.centre) + a.half[0] + a.half[1] +
                                    a.half[2] + b.half[0] + b.half[1] + b.half[2]);
  const double squared =
      most(squaredGapAlong(a, b, offset, slack), squaredGapAlong(b, a, offset, slack));
  // The axes are orthogonal, so a vector's length is the root of the sum of its squared parts.
  return std::sqrt(squared) * (1 - 1e-12);
}

void PosedTile::make(const Tiling& tiling, std::size_t tile, const PosedBody& body) {
  const std::uint32_t begin = tiling.tile_begin[tile];
  count = tiling.tile_begin[tile + 1] - begin;
  std::copy_n(tiling.triangle.begin() + begin, count, triangle.begin());
  std::copy_n(tiling.corners.begin() + begin, count, corners.begin());
  const std::uint32_t first = tiling.vertex_begin[tile];
  vertex_count = tiling.vertex_begin[tile + 1] - first;
  finish(tiling.vertex.data() + first, body);
}

void PosedTile::makeRun(const TriangleMesh& mesh, std::size_t first, const PosedBody& body) {
  count = std::min(kTriangles, mesh.triangleCount() - first);
  vertex_count = 3 * count;
  for (std::size_t t = 0; t < count; ++t) {
    triangle[t] = static_cast<std::uint32_t>(first + t);
    for (std::size_t k = 0; k < 3; ++k) corners[t][k] = static_cast<std::uint8_t>(3 * t + k);
  }
  finish(mesh.triangles.data() + 3 * first, body);
}

// Reads the vertices, whose indices in the body are given, and makes the boxes.
void PosedTile::finish(const std::uint32_t* vertices, const PosedBody& body) {
  float check = 0;  // becomes NaN with the first coordinate that is not finite
  for (std::size_t i = 0; i < vertex_count; ++i) {
    const Vec3f v = body.vertex(vertices[i]);
    x[i] = v.x;
    y[i] = v.y;
    z[i] = v.z;
    check += (v.x - v.x) + (v.y - v.y) + (v.z - v.z);
  }
  if (check != 0) dropRejected();
  if (count > 0) findBoxes();
}

// Keeps the triangles whose vertices are finite, and renumbers the vertices that these still use.
void PosedTile::dropRejected() {
  constexpr std::uint8_t kUnused = 255;
  std::array<std::uint8_t, 3 * kTriangles> place;
  place.fill(kUnused);
  const std::array<float, 3 *kTriangles> all_x = x, all_y = y, all_z = z;
  const std::size_t all = count;
  count = vertex_count = 0;
  for (std::size_t t = 0; t < all; ++t) {
    const std::array<std::uint8_t, 3> corner = corners[t];
    const bool finite = std::all_of(corner.begin(), corner.end(), [&](std::uint8_t i) {
      return isFinite(Vec3f{all_x[i], all_y[i], all_z[i]});
    });
    if (!finite) continue;
    triangle[count] = triangle[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint8_t i = corner[k];
      if (place[i] == kUnused) {
        x[vertex_count] = all_x[i];
        y[vertex_count] = all_y[i];
        z[vertex_count] = all_z[i];
        place[i] = static_cast<std::uint8_t>(vertex_count++);
      }
      corners[count][k] = place[i];
    }
    ++count;
  }
}

// The mean normal of the triangles is the direction in which the oriented box is thin.
void PosedTile::findBoxes() {
  box = Aabb();
  Vec3d normal;  // the sum of the triangles' normals, weighted by area
  for (std::size_t t = 0; t < count; ++t) {
    const Triangle hull = posed(t);
    const Aabb own = boxOf(hull);
    box.include(own);
    for (std::size_t k = 0; k < 3; ++k) {
      low[k][t] = own.min[static_cast<int>(k)];
      high[k][t] = own.max[static_cast<int>(k)];
    }
    normal = normal + doubleAreaNormal(hull);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    std::fill(low[k].begin() + static_cast<std::ptrdiff_t>(count), low[k].end(), low[k][count - 1]);
    std::fill(high[k].begin() + static_cast<std::ptrdiff_t>(count), high[k].end(),
              high[k][count - 1]);
  }
  oriented = orientedBoxOf(x.data(), y.data(), z.data(), vertex_count, normal);
}

}  // namespace deformable_contact_monitor
