// Draws a surface with fewer triangles and without holes, by vertex clustering.
//
// choose() tries cell sizes until the number of triangles is just below the limit. Clustering does
// the work for one cell size: it assigns vertices to cells, joins connected vertices within a cell,
// replaces each set by its vertex nearest to the cell's center, and lists what triangles remain.
#include "monitor/markers/decimated_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/analysis/union_find.h"
#include "core/common/vertex_identity.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

using Corners = std::array<std::uint32_t, 3>;

constexpr double kMostCells = 1 << 20;  // per axis, so that three cell numbers fit into 64 bits

// Returns a vertex in double precision.
Eigen::Array3d position(const TriangleMesh& mesh, std::size_t i) {
  return Eigen::Map<const Eigen::Array3f>(&mesh.vertices[3 * i]).cast<double>();
}

// Clusters the vertices of a mesh in a grid of one cell size.
class Clustering {
 public:
  // `welded`: for each vertex one vertex with the same coordinates. With it, triangles that share
  // no vertex index (a triangle soup) are connected like those of a welded mesh. `low`: the least
  // coordinates of the mesh.
  Clustering(const TriangleMesh& mesh, const std::vector<std::uint32_t>& welded,
             const Eigen::Array3d& low, double cell_m)
      : mesh_(mesh), low_(low), cell_m_(cell_m), cells_(mesh.vertexCount()) {
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

  // Returns a vertex's place in the grid, in cell sizes.
  Eigen::Array3d placeOf(std::size_t i) const { return (position(mesh_, i) - low_) / cell_m_; }

  // Returns the cell of a vertex: 21 bits per axis; kNowhere if the vertex is not finite.
  std::uint64_t cellOf(std::size_t i) const {
    if (!isFinite(mesh_.vertex(i))) return kNowhere;
    const Eigen::Array3d n = placeOf(i).floor().max(0).min(kMostCells);
    return static_cast<std::uint64_t>(n[0]) << 42U | static_cast<std::uint64_t>(n[1]) << 21U |
           static_cast<std::uint64_t>(n[2]);
  }

  // Returns a vertex's squared distance to the center of its cell, in cell sizes.
  double squaredDistanceToCenter(std::size_t i) const {
    const Eigen::Array3d n = placeOf(i);
    return (n - n.floor() - 0.5).square().sum();
  }

  // Joins vertices only along edges. Layers of a folded cloth that lie in the same cell stay apart,
  // because they may move away from each other.
  void joinWithinCells(const std::vector<std::uint32_t>& welded) {
    UnionFind sets(cells_.size());
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
      std::uint32_t& of_set = best[sets.find(i)];
      if (squaredDistanceToCenter(i) < squaredDistanceToCenter(of_set)) of_set = i;
    }
    vertex_.resize(cells_.size());
    for (std::uint32_t i = 0; i < cells_.size(); ++i) vertex_[i] = best[sets.find(i)];
  }

  const TriangleMesh& mesh_;
  const Eigen::Array3d low_;
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
  Eigen::AlignedBox3d extent;  // of the finite vertices
  bool all_finite = true;
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i) {
    if (isFinite(mesh.vertex(i))) {
      extent.extend(position(mesh, i).matrix());
    } else {
      all_finite = false;
    }
  }
  std::vector<std::uint32_t> welded;
  VertexIdentity().identify(mesh.vertices, welded);
  const double longest_m = extent.isEmpty() ? 0 : extent.sizes().maxCoeff();
  const double whole_m = std::max(longest_m, std::numeric_limits<double>::min());
  double cell_m = cell_m_;
  if (!(cell_m > whole_m / kMostCells && cell_m <= whole_m)) {
    cell_m = whole_m / std::sqrt(static_cast<double>(limit_) / 2 + 1);
  }
  HostList<std::uint32_t> best;
  bool fits = false;
  for (int i = 0; i < kTries || !fits; ++i) {
    HostList<std::uint32_t> found = Clustering(mesh, welded, extent.min(), cell_m).remaining();
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
  is_chosen_ = all_finite;
}

}  // namespace deformable_contact_monitor
