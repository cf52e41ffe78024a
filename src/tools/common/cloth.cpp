// A square sheet of cloth that is held at one edge, falls, and is pushed by capsules.
#include "tools/common/cloth.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

constexpr double kGravity = 9.81;     // [m/s^2]
constexpr double kSubstep = 0.008;    // [s], longest
constexpr int kPasses = 8;            // over all springs, a substep
constexpr double kDamping = 1.5;      // [1/s]
constexpr double kMaxSpeed = 4;       // [m/s]: no vertex crosses an arm within a substep
constexpr double kFriction = 0.3;     // share of a touching vertex's sliding that is taken away
constexpr double kMaxStretch = 1.02;  // of a vertex's way to the held edge
constexpr double kUnevenness = 0.02;  // of the grid's spacing
constexpr double kTooNear = 1e-12;    // [m]: a direction cannot be told
constexpr double kThinnest = 1.5;  // obstacle's radius in spacings: thinner ones pierce the sheet

// Returns the point of the capsule's axis that is nearest to p.
Eigen::Vector3d nearestOnAxis(const Capsule& capsule, const Eigen::Vector3d& p) {
  const Eigen::Vector3d axis = capsule.b - capsule.a;
  const double length2 = axis.squaredNorm();
  const double t = length2 > 0 ? (p - capsule.a).dot(axis) / length2 : 0;
  return capsule.a + std::clamp(t, 0.0, 1.0) * axis;
}

}  // namespace

// Makes a flat sheet of 2 n^2 triangles, slightly uneven, so that it folds the same way each time.
Cloth::Cloth(const ClothOptions& options)
    : cells_(std::max(1, static_cast<int>(std::lround(std::sqrt(options.triangles / 2.0))))),
      spacing_m_(options.edge_m / cells_) {
  if (options.triangles < 1) throw std::invalid_argument("a cloth needs at least one triangle");
  if (!(options.edge_m > 0) || !std::isfinite(options.edge_m) || !options.held_at.allFinite()) {
    throw std::invalid_argument("a cloth needs a finite place and a finite size above zero");
  }
  // std::mt19937's numbers are the same everywhere; the standard's distributions are not.
  std::mt19937 random(options.seed);
  for (int row = 0; row <= cells_; ++row) {
    for (int column = 0; column <= cells_; ++column) {
      const double uneven = row == 0 ? 0 : random() / 4294967296.0 - 0.5;
      positions_.push_back(options.held_at + spacing_m_ * Eigen::Vector3d(-row,
                                                                          column - cells_ / 2.0,
                                                                          kUnevenness * uneven));
    }
  }
  before_ = positions_;
  velocities_.assign(positions_.size(), Eigen::Vector3d::Zero());
  addSprings();
}

// Connects each vertex to its neighbours along the grid (stretch), across its cells (shear), and
// two cells away (bending, which is weak). The order runs from the held edge downwards, so that one
// pass carries the hold through the whole sheet.
void Cloth::addSprings() {
  const double diagonal = std::sqrt(2.0) * spacing_m_;
  for (int row = 0; row <= cells_; ++row) {
    for (int column = 0; column <= cells_; ++column) {
      const std::size_t here = at(row, column);
      if (row > 0) springs_.push_back({at(row - 1, column), here, spacing_m_, 1});
      if (column > 0) springs_.push_back({at(row, column - 1), here, spacing_m_, 1});
      if (row > 0 && column > 0) {
        springs_.push_back({at(row - 1, column - 1), here, diagonal, 0.3});
        springs_.push_back({at(row - 1, column), at(row, column - 1), diagonal, 0.3});
      }
      if (row > 1) springs_.push_back({at(row - 2, column), here, 2 * spacing_m_, 0.05});
      if (column > 1) springs_.push_back({at(row, column - 2), here, 2 * spacing_m_, 0.05});
    }
  }
}

// Moves the two ends so that the spring gets its length. Held vertices do not move.
void Cloth::satisfy(const Spring& spring) {
  const std::size_t held = static_cast<std::size_t>(cells_) + 1;
  const double weight_a = spring.a < held ? 0 : 1, weight_b = spring.b < held ? 0 : 1;
  if (weight_a + weight_b == 0) return;
  Eigen::Vector3d& a = positions_[spring.a];
  Eigen::Vector3d& b = positions_[spring.b];
  const Eigen::Vector3d way = b - a;
  const double length = way.norm();
  if (length < kTooNear) return;
  const Eigen::Vector3d move =
      way * (spring.stiffness * (length - spring.length_m) / (length * (weight_a + weight_b)));
  a += weight_a * move;
  b -= weight_b * move;
}

// Keeps each vertex within the length of the cloth between it and its column's held vertex. Springs
// alone need many passes to hold the weight of a large sheet.
void Cloth::limitStretch() {
  for (int row = 1; row <= cells_; ++row) {
    const double longest = kMaxStretch * row * spacing_m_;
    for (int column = 0; column <= cells_; ++column) {
      const Eigen::Vector3d& hold = positions_[at(0, column)];
      Eigen::Vector3d& vertex = positions_[at(row, column)];
      const Eigen::Vector3d way = vertex - hold;
      const double length = way.norm();
      if (length > longest) vertex = hold + way * (longest / length);
    }
  }
}

// Moves vertices out of an obstacle, and takes away a part of their sliding as friction.
void Cloth::pushOut(const Capsule& obstacle) {
  const double radius = std::max(obstacle.radius_m, kThinnest * spacing_m_);
  for (std::size_t i = at(1, 0); i < positions_.size(); ++i) {
    const Eigen::Vector3d axis_point = nearestOnAxis(obstacle, positions_[i]);
    Eigen::Vector3d out = positions_[i] - axis_point;
    const double distance = out.norm();
    if (distance >= radius) continue;
    out = distance < kTooNear ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d(out / distance);
    const Eigen::Vector3d moved = positions_[i] - before_[i];
    const Eigen::Vector3d sliding = moved - out * out.dot(moved);
    positions_[i] = axis_point + out * radius;
    // Less sliding must not lead back into the obstacle.
    const Eigen::Vector3d slowed = positions_[i] - kFriction * sliding;
    if ((slowed - nearestOnAxis(obstacle, slowed)).norm() >= radius) {
      positions_[i] = slowed;
    }
  }
}

// Position-based dynamics: predict positions, correct them by springs and obstacles, and derive the
// velocities from what came out.
void Cloth::substep(double dt_s, const std::vector<Capsule>& obstacles) {
  before_ = positions_;
  const double keep = std::exp(-kDamping * dt_s);
  for (std::size_t i = at(1, 0); i < positions_.size(); ++i) {
    velocities_[i].z() -= kGravity * dt_s;
    velocities_[i] *= keep;
    const double speed = velocities_[i].norm();
    if (speed > kMaxSpeed) velocities_[i] *= kMaxSpeed / speed;
    positions_[i] += dt_s * velocities_[i];
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    for (const Spring& spring : springs_) satisfy(spring);
  }
  limitStretch();
  for (const Capsule& obstacle : obstacles) pushOut(obstacle);
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    velocities_[i] = (positions_[i] - before_[i]) / dt_s;
  }
}

// Divides the time into equal substeps that are short enough to be stable.
void Cloth::step(double dt_s, const std::vector<Capsule>& obstacles) {
  const int substeps = std::max(1, static_cast<int>(std::ceil(dt_s / kSubstep)));
  for (int i = 0; i < substeps; ++i) substep(dt_s / substeps, obstacles);
}

// Each cell of the grid becomes two triangles.
TriangleMesh Cloth::mesh() const {
  TriangleMesh mesh;
  mesh.vertices.reserve(3 * positions_.size());
  for (const Eigen::Vector3d& p : positions_) {
    for (int axis = 0; axis < 3; ++axis) mesh.vertices.push_back(static_cast<float>(p[axis]));
  }
  for (int row = 0; row < cells_; ++row) {
    for (int column = 0; column < cells_; ++column) {
      const auto corner = [&](int r, int c) {
        return static_cast<std::uint32_t>(at(row + r, column + c));
      };
      mesh.triangles.insert(mesh.triangles.end(), {corner(0, 0), corner(1, 0), corner(0, 1)});
      mesh.triangles.insert(mesh.triangles.end(), {corner(0, 1), corner(1, 0), corner(1, 1)});
    }
  }
  return mesh;
}

}  // namespace deformable_contact_monitor
