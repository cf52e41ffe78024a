// Up to six points that move on straight lines, and the determinants that say how they lie.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "algebraic_time.h"

namespace deformable_contact_monitor {

using RationalPoint = std::array<mpq_class, 3>;

// At `start` at time 0, at `end` at time 1.
struct Trajectory {
  RationalPoint start, end;
};

bool operator==(const Trajectory& a, const Trajectory& b);

// A set of points, by their bits.
using PointSet = unsigned;

constexpr PointSet only(int point) { return 1U << point; }
int sizeOf(PointSet set);
std::vector<int> pointsOf(PointSet set);  // ascending

// A polynomial in time, and its roots in [0, 1] once asked for.
class Event {
 public:
  explicit Event(IntegerPolynomial polynomial) : polynomial_(std::move(polynomial)) {}

  bool isNever() const { return polynomial_.degree() == 0; }
  bool isAlways() const { return polynomial_.isZero(); }
  const IntegerPolynomial& polynomial() const { return polynomial_; }
  // Ascending, each once. Not for one that is always.
  const std::vector<AlgebraicTime>& roots();

 private:
  IntegerPolynomial polynomial_;
  std::optional<std::vector<AlgebraicTime>> roots_;
};

class MovingPoints {
 public:
  explicit MovingPoints(const std::vector<Trajectory>& points);

  PointSet all() const { return (1U << coordinates_.size()) - 1; }

  // The signed volumes of k + 1 points in their projections onto k coordinates, a polynomial of
  // degree k for each choice of coordinates: one of four points, three of three points or of two,
  // the constant 1 of one. They are all 0 iff the points are affinely dependent. More points are
  // always so: none.
  std::vector<Event>& volumes(PointSet points);

  // Returns whether there is an axis on which all points of one set are before all points of the
  // other, in both states. If so, they are apart at all times, because differences of coordinates
  // are linear in time.
  bool areApart(PointSet a, PointSet b) const;

 private:
  std::vector<Event> volumesOf(const std::vector<int>& points);

  struct Coordinate {
    mpz_class start, end;
  };
  std::vector<std::array<Coordinate, 3>> coordinates_;  // scaled to integers, all by one factor
  std::vector<std::array<PointSet, 3>> behind_;         // of a point: what is after it, by axis
  std::map<PointSet, std::vector<Event>> volumes_;
};

}  // namespace deformable_contact_monitor
