#include "core/predicates/swept_instant.h"

#include <algorithm>
#include <cmath>

namespace deformable_contact_monitor {
namespace {

// x = mantissa * 2^exponent, |mantissa| < 2^24; a zero has a large exponent.
std::int64_t mantissaOf(float x, int& exponent) {
  exponent = 1000;
  if (x == 0) return 0;
  const float fraction = std::frexp(x, &exponent);
  exponent -= 24;
  return static_cast<std::int64_t>(std::ldexp(fraction, 24));
}

std::size_t place(int point, int axis) {
  return 3 * static_cast<std::size_t>(point) + static_cast<std::size_t>(axis);
}

}  // namespace

ExactMotion::ExactMotion(const MovingPoint* points, int count) : count_(count) {
  int low = 1000;
  for (int i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const float x : {points[i].from[axis], points[i].to[axis]}) {
        int exponent;
        mantissaOf(x, exponent);
        low = std::min(low, exponent);
      }
    }
  }
  const auto scaled = [low](float x) {
    int exponent;
    const std::int64_t mantissa = mantissaOf(x, exponent);
    return mantissa == 0 ? GrowingInteger(0) : GrowingInteger(mantissa) << (exponent - low);
  };
  for (int i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      from_.push_back(scaled(points[i].from[axis]));
      to_.push_back(scaled(points[i].to[axis]));
    }
  }
}

Polynomial ExactMotion::difference(int a, int b, int axis) const {
  const std::size_t i = place(a, axis), j = place(b, axis);
  const GrowingInteger start = from_[j] - from_[i];
  return Polynomial::linear(start, to_[j] - to_[i] - start);
}

Polynomial ExactMotion::orientation(int a, int b, int c, int axis) const {
  const int i = axis == 2 ? 0 : axis + 1, j = axis == 0 ? 2 : axis - 1;
  return difference(a, b, i) * difference(a, c, j) - difference(a, b, j) * difference(a, c, i);
}

Polynomial ExactMotion::orientation3(int a, int b, int c, int d) const {
  Polynomial sum;
  for (int axis = 0; axis < 3; ++axis) {
    sum = sum + orientation(a, b, c, axis) * difference(a, d, axis);
  }
  return sum;
}

}  // namespace deformable_contact_monitor
