// Decides which polygons are convex, and has the others triangulated in their own plane. A polygon
// is projected along the coordinate axis that is nearest to its normal, which changes no bit of the
// two other coordinates, so the exact predicates see the numbers of the file.
#include "core/mesh_files/polygons.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh_files/ear_clipping.h"
#include "core/predicates/orientation.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

// A polygon is planar if no corner is farther from its mean plane than this part of its longest
// side along an axis. Rounded decimals in files are less, folds in cloth are mostly more.
constexpr double kPlanar = 0.01;

// The boxes that ear clipping may test for the polygons of one file, which takes some seconds. Most
// polygons of 100 000 corners take less; long slanted teeth of a comb take more from 20 000 on.
constexpr std::uint64_t kMostWork = 300'000'000;

bool isBefore(const Vec3f& a, const Vec3f& b) {
  return a.x != b.x ? a.x < b.x : (a.y != b.y ? a.y < b.y : a.z < b.z);
}

// Returns twice the vector area of the polygon (Newell's normal). It is nearly exact, also far from
// the origin, because it is computed from one of the corners.
Vec3d areaOf(const std::vector<Vec3f>& corners) {
  const Vec3d origin = toDouble(corners[0]);
  Vec3d area{0, 0, 0};
  for (std::size_t i = 2; i < corners.size(); ++i) {
    area = area + cross(toDouble(corners[i - 1]) - origin, toDouble(corners[i]) - origin);
  }
  return area;
}

double lengthOf(const Vec3d& v) { return std::sqrt(dot(v, v)); }

// Returns whether all corners are on one line.
bool isOnALine(const std::vector<Vec3f>& corners) {
  const auto other = std::find_if(corners.begin(), corners.end(), [&](const Vec3f& p) {
    return isBefore(p, corners[0]) || isBefore(corners[0], p);
  });
  if (other == corners.end()) return true;
  PredicateState state;
  return std::all_of(corners.begin(), corners.end(), [&](const Vec3f& p) {
    for (int axis = 0; axis < 3; ++axis) {
      if (orient2d(corners[0], *other, p, axis, state) != 0) return false;
    }
    return true;
  });
}

// Returns whether the corners are in one plane, apart from rounding. `area` must not be zero.
bool isPlanar(const std::vector<Vec3f>& corners, const Vec3d& area) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double low[3] = {kInfinity, kInfinity, kInfinity};
  double high[3] = {-kInfinity, -kInfinity, -kInfinity};
  double nearest = kInfinity, farthest = -kInfinity, largest = 0;
  const double length = lengthOf(area);
  const Vec3d origin = toDouble(corners[0]);
  for (const Vec3f& corner : corners) {
    const double height = dot(toDouble(corner) - origin, area) / length;
    nearest = std::min(nearest, height);
    farthest = std::max(farthest, height);
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min<double>(low[axis], corner[axis]);
      high[axis] = std::max<double>(high[axis], corner[axis]);
      largest = std::max<double>(largest, std::abs(corner[axis]));
    }
  }
  const double side = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  const double rounding = 4 * static_cast<double>(std::numeric_limits<float>::epsilon()) * largest;
  return (farthest - nearest) / 2 <= kPlanar * side + rounding;
}

// Returns the corners as seen from the side from which they go counter-clockwise, with z = 0.
std::vector<Vec3f> projectedCorners(const std::vector<Vec3f>& corners, const Vec3d& area) {
  const double x = std::abs(area.x), y = std::abs(area.y), z = std::abs(area.z);
  const int axis = x > y && x > z ? 0 : (y > z ? 1 : 2);
  const bool is_positive = (axis == 0 ? area.x : (axis == 1 ? area.y : area.z)) > 0;
  std::vector<Vec3f> seen;
  seen.reserve(corners.size());
  for (const Vec3f& corner : corners) {
    float u, v;
    projected(corner, axis, u, v);
    seen.push_back(is_positive ? Vec3f{u, v, 0} : Vec3f{v, u, 0});
  }
  return seen;
}

// Returns whether a polygon in the plane turns only left, and once around. Then its sides go to the
// right in one stretch and to the left in another. Corners equal to the one before are left out:
// the turn is where the next other corner comes.
bool isConvex(std::vector<Vec3f> corners) {
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
  const std::size_t size = corners.size();
  PredicateState state;
  int changes = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const Vec3f &a = corners[i], &b = corners[(i + 1) % size], &c = corners[(i + 2) % size];
    if (orient2d(a, b, c, 2, state) < 0) return false;
    changes += isBefore(a, b) != isBefore(b, c) ? 1 : 0;
  }
  return changes <= 2;
}

// Returns the corner from which the list of coordinates is least (by the algorithm of two starts
// for least rotations, in linear time). It is the same corner whatever corner the polygon begins
// with, so its triangles are the same ones, too.
std::size_t leastStart(const std::vector<Vec3f>& corners) {
  const std::size_t size = corners.size();
  std::size_t one = 0, other = 1, same = 0;
  while (one < size && other < size && same < size) {
    const Vec3f &a = corners[(one + same) % size], &b = corners[(other + same) % size];
    if (!isBefore(a, b) && !isBefore(b, a)) {
      ++same;
      continue;
    }
    (isBefore(b, a) ? one : other) += same + 1;
    if (one == other) ++other;
    same = 0;
  }
  return std::min(one, other);
}

// Tells what becomes of a polygon.
enum class Outcome {
  kFan,     // the fan is the polygon's surface
  kEars,    // other triangles are
  kUnclear  // it has no plane, or crosses itself: it stays a fan
};

// Finds the triangles of a polygon with these corners. They are numbers of corners.
Outcome trianglesOf(std::vector<Vec3f> corners, std::vector<PolygonTriangle>* triangles,
                    std::uint64_t* work) {
  if (!std::all_of(corners.begin(), corners.end(), [](const Vec3f& p) { return isFinite(p); })) {
    return Outcome::kUnclear;
  }
  Vec3d area = areaOf(corners);
  if (lengthOf(area) == 0) return isOnALine(corners) ? Outcome::kFan : Outcome::kUnclear;
  if (!isPlanar(corners, area)) return Outcome::kUnclear;
  if (isConvex(projectedCorners(corners, area))) return Outcome::kFan;
  const std::size_t start = leastStart(corners), size = corners.size();
  std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(start), corners.end());
  area = areaOf(corners);
  auto ears = clipEars(projectedCorners(corners, area), work);
  if (!ears) return Outcome::kUnclear;
  *triangles = std::move(*ears);
  for (PolygonTriangle& triangle : *triangles) {
    for (std::uint32_t& corner : triangle) {
      corner = static_cast<std::uint32_t>((corner + start) % size);
    }
  }
  return Outcome::kEars;
}

}  // namespace

void PolygonList::begin() {
  if (size_ > 3) polygons_.push_back({begin_, size_});
  begin_ = triangles_->size();
  size_ = 0;
}

void PolygonList::triangulate(const HostList<float>& vertices, MeshFileReport* report) {
  begin();
  std::uint64_t work = kMostWork;
  std::size_t unclear = 0, first_unclear = 0;
  std::vector<std::uint32_t> indices;
  std::vector<Vec3f> corners;
  std::vector<PolygonTriangle> triangles;
  for (const Polygon& polygon : polygons_) {
    // Triangle t of a fan is made of the corners 0, t + 1 and t + 2.
    std::uint32_t* const at = triangles_->data() + polygon.first;
    indices.assign({at[0], at[1]});
    for (std::size_t t = 0; t + 2 < polygon.size; ++t) indices.push_back(at[3 * t + 2]);
    corners.clear();
    for (const std::uint32_t vertex : indices) {
      const float* const v = &vertices[3 * std::size_t{vertex}];
      corners.push_back({v[0], v[1], v[2]});
    }
    const Outcome outcome = trianglesOf(corners, &triangles, &work);
    if (outcome == Outcome::kEars) {
      if (report->fans.empty()) report->fans = *triangles_;
      for (std::size_t i = 0; i < 3 * triangles.size(); ++i)
        at[i] = indices[triangles[i / 3][i % 3]];
    } else if (outcome == Outcome::kUnclear && unclear++ == 0) {
      first_unclear = polygon.first / 3;
    }
  }
  if (unclear == 0) return;
  report->notes.push_back(
      std::to_string(unclear) + " of " + std::to_string(polygons_.size()) +
      " polygons of 4 or more corners are not planar, cross themselves or have a "
      "corner that is not finite; they became fans around their first corner, which "
      "may differ from the surface that was meant (the first one begins with triangle " +
      std::to_string(first_unclear) + ")");
}

}  // namespace deformable_contact_monitor
