// Draws a surface with fewer triangles and without holes, by vertex clustering.
//
// choose() tries cell sizes until the number of triangles is just below the limit. Clustering does
// the work for one cell size: it assigns vertices to cells, joins connected vertices within a cell,
// replaces each set by its vertex nearest to the cell's center, and lists what triangles remain.
#include "monitor/markers/decimated_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

using Corners = std::array<std::uint32_t, 3>;

constexpr double kMostCells = 1 << 20;  // per axis, so that three cell numbers fit into 64 bits

// The box of the finite vertices.
struct Extent {
  std::array<double, 3> low{}, high{};
  bool any = false, all_finite = true;

  double longest() const {
    return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  }
};

std::array<double, 3> position(const TriangleMesh& mesh, std::size_t i) {
  const Vec3f v = mesh.vertex(i);
  return {v.x, v.y, v.z};
}

bool isFinite(const std::array<double, 3>& p) { return std::isfinite(p[0] + p[1] + p[2]); }

// Returns the box of a mesh, and whether all its vertices are finite.
Extent extentOf(const TriangleMesh& mesh) {
  Extent extent;
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) {
    const std::array<double, 3> p = position(mesh, i);
    if (!isFinite(p)) {
      extent.all_finite = false;
      continue;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent.low[axis] = extent.any ? std::min(extent.low[axis], p[axis]) : p[axis];
      extent.high[axis] = extent.any ? std::max(extent.high[axis], p[axis]) : p[axis];
    }
    extent.any = true;
  }
  return extent;
}

// Returns for each vertex one vertex with the same coordinates. With it, triangles that share no
// vertex index (a triangle soup) are connected like those of a welded mesh.
std::vector<std::uint32_t> welded(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertexCount());
  std::iota(order.begin(), order.end(), 0U);
  std::vector<std::uint32_t> same = order;
  order.erase(std::remove_if(order.begin(), order.end(),
                             [&](std::uint32_t i) { return !isFinite(position(mesh, i)); }),
              order.end());
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::make_pair(position(mesh, a), a) < std::make_pair(position(mesh, b), b);
  });
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (position(mesh, order[i]) == position(mesh, order[i - 1]))
      same[order[i]] = same[order[i - 1]];
  }
  return same;
}

// Disjoint sets of vertices (union-find), each represented by one of its vertices.
class VertexSets {
 public:
  explicit VertexSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  std::uint32_t of(std::uint32_t i) {
    for (; parent_[i] != i; i = parent_[i]) parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[of(a)] = of(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

// Clusters the vertices of a mesh in a grid of one cell size.
class Clustering {
 public:
  Clustering(const TriangleMesh& mesh, const std::vector<std::uint32_t>& welded,
             const Extent& extent, double cell_m)
      : mesh_(mesh), extent_(extent), cell_m_(cell_m), cells_(mesh.vertexCount()) {
    for (std::size_t i = 0; i < cells_.size(); ++i) cells_[i] = cellOf(i);
    joinWithinCells(welded);
  }

  // Returns the remaining triangles, sorted by their corners. Of those with the same corners, one
  // remains, or two if their number is even.
  HostList<std::uint32_t> remaining() const {
    std::vector<std::pair<Corners, std::size_t>> keyed;
    const HostList<std::uint32_t>& t = mesh_.triangles;
    for (std::size_t i = 0; i < t.size(); i += 3) {
      Corners key{vertex_[t[i]], vertex_[t[i + 1]], vertex_[t[i + 2]]};
      if (key[0] == key[1] || key[1] == key[2] || key[2] == key[0]) continue;
      if (cells_[t[i]] == kNowhere || cells_[t[i + 1]] == kNowhere ||
          cells_[t[i + 2]] == kNowhere) {
        continue;
      }
      std::sort(key.begin(), key.end());
      keyed.emplace_back(key, i);
    }
    std::sort(keyed.begin(), keyed.end());
    HostList<std::uint32_t> out;
    for (std::size_t first = 0, end = 0; first < keyed.size(); first = end) {
      while (end < keyed.size() && keyed[end].first == keyed[first].first) ++end;
      for (std::size_t i = first; i < end && i < first + ((end - first) % 2 == 0 ? 2 : 1); ++i) {
        for (std::size_t k = 0; k < 3; ++k) out.push_back(vertex_[t[keyed[i].second + k]]);
      }
    }
    return out;
  }

 private:
  static constexpr std::uint64_t kNowhere = std::numeric_limits<std::uint64_t>::max();

  // Returns the cell of a vertex: 21 bits per axis; kNowhere if the vertex is not finite.
  std::uint64_t cellOf(std::size_t i) const {
    const std::array<double, 3> p = position(mesh_, i);
    if (!isFinite(p)) return kNowhere;
    std::uint64_t cell = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double n = std::floor((p[axis] - extent_.low[axis]) / cell_m_);
      cell = (cell << 21U) | static_cast<std::uint64_t>(std::min(std::max(n, 0.0), kMostCells));
    }
    return cell;
  }

  // Returns a vertex's squared distance to the center of its cell, in cell sizes.
  double squaredDistanceToCenter(std::size_t i) const {
    const std::array<double, 3> p = position(mesh_, i);
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double n = (p[axis] - extent_.low[axis]) / cell_m_;
      sum += (n - std::floor(n) - 0.5) * (n - std::floor(n) - 0.5);
    }
    return sum;
  }

  // Joins vertices only along edges. Layers of a folded cloth that lie in the same cell stay apart,
  // because they may move away from each other.
  void joinWithinCells(const std::vector<std::uint32_t>& welded) {
    VertexSets sets(cells_.size());
    const auto join = [&](std::uint32_t a, std::uint32_t b) {
      if (cells_[a] == cells_[b] && cells_[a] != kNowhere) sets.join(a, b);
    };
    for (std::uint32_t i = 0; i < welded.size(); ++i) join(i, welded[i]);
    const HostList<std::uint32_t>& t = mesh_.triangles;
    for (std::size_t i = 0; i < t.size(); i += 3) {
      join(t[i], t[i + 1]);
      join(t[i + 1], t[i + 2]);
      join(t[i + 2], t[i]);
    }
    std::vector<std::uint32_t> best(cells_.size());
    std::iota(best.begin(), best.end(), 0U);
    for (std::uint32_t i = 0; i < cells_.size(); ++i) {
      std::uint32_t& of_set = best[sets.of(i)];
      if (squaredDistanceToCenter(i) < squaredDistanceToCenter(of_set)) of_set = i;
    }
    vertex_.resize(cells_.size());
    for (std::uint32_t i = 0; i < cells_.size(); ++i) vertex_[i] = best[sets.of(i)];
  }

  const TriangleMesh& mesh_;
  const Extent& extent_;
  const double cell_m_;
  std::vector<std::uint64_t> cells_;
  std::vector<std::uint32_t> vertex_;  // what each vertex became
};

}  // namespace

// Compares all triangles with those of the choice, which is cheap beside drawing them.
const HostList<std::uint32_t>& DecimatedSurface::triangles(const TriangleMesh& mesh) {
  if (mesh.triangleCount() <= limit_) return mesh.triangles;
  if (!is_chosen_ || source_ != mesh.triangles) choose(mesh);
  return remaining_;
}

// The number of triangles falls with the square of the cell size, so the second try mostly fits.
void DecimatedSurface::choose(const TriangleMesh& mesh) {
  constexpr int kTries = 8;
  const Extent extent = extentOf(mesh);
  const std::vector<std::uint32_t> same = welded(mesh);
  const double whole_m = std::max(extent.longest(), std::numeric_limits<double>::min());
  double cell_m = cell_m_;
  if (!(cell_m > whole_m / kMostCells && cell_m <= whole_m)) {
    cell_m = whole_m / std::sqrt(static_cast<double>(limit_) / 2 + 1);
  }
  HostList<std::uint32_t> best;
  bool fits = false;
  for (int i = 0; i < kTries || !fits; ++i) {
    HostList<std::uint32_t> found = Clustering(mesh, same, extent, cell_m).remaining();
    const double share = static_cast<double>(found.size()) / 3 / static_cast<double>(limit_);
    if (share <= 1 && (!fits || found.size() > best.size())) {
      best = std::move(found);
      fits = true;
      cell_m_ = cell_m;
    }
    if (fits && 3 * limit_ <= 2 * best.size()) break;
    // Aims at 85 % of the limit. The loop ends, because with a cell as large as the mesh nothing
    // remains.
    cell_m *= std::clamp(std::sqrt(share / 0.85), 0.5, 2.0) * (share > 1 ? 1.05 : 1);
  }
  remaining_ = std::move(best);
  source_ = mesh.triangles;
  is_chosen_ = extent.all_finite;
}

}  // namespace deformable_contact_monitor
