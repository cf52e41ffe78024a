// Points and vectors as plain structs, for host and device.
#pragma once

#include <cmath>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// Return the lesser and the greater of two numbers. The result for NaN is unspecified, so callers
// exclude it. They compile to one instruction, unlike fmin and fmax on a CPU; on a GPU those do so
// for float.
template <class Real>
DCM_HD inline Real least(Real a, Real b) {
  return b < a ? b : a;
}
template <class Real>
DCM_HD inline Real most(Real a, Real b) {
  return a < b ? b : a;
}
#ifdef __CUDA_ARCH__
DCM_HD inline float least(float a, float b) { return fminf(a, b); }
DCM_HD inline float most(float a, float b) { return fmaxf(a, b); }
#endif

// Returns the float32 that is nearest to x. Use it where the rounding decides something: g++ 12 and
// others leave out a conversion to float32 and back to double if they convert several numbers at
// once (CMakeLists.txt). They cannot see through this function.
DCM_HD inline float toFloat(double x) {
  auto rounded = static_cast<float>(x);
#if defined(__GNUC__) && !defined(__clang__) && !defined(__CUDA_ARCH__)
#if defined(__x86_64__)
  asm("" : "+x"(rounded));
#elif defined(__aarch64__)
  asm("" : "+w"(rounded));
#endif
#endif
  return rounded;
}

template <class Real>
struct Vec3 {
  Real x = 0, y = 0, z = 0;

  DCM_HD Real operator[](int axis) const { return axis == 0 ? x : (axis == 1 ? y : z); }

  // Compares coordinates; -0 equals 0.
  friend DCM_HD bool operator==(const Vec3& a, const Vec3& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  }
  friend DCM_HD bool operator!=(const Vec3& a, const Vec3& b) { return !(a == b); }
  friend DCM_HD Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend DCM_HD Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend DCM_HD Vec3 operator*(const Vec3& a, Real s) { return {a.x * s, a.y * s, a.z * s}; }
  friend DCM_HD Real dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  friend DCM_HD Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

// Returns whether all coordinates are finite. x - x is 0 for a finite x and NaN otherwise, so one
// comparison checks all three.
DCM_HD inline bool isFinite(const Vec3f& v) {
  return (v.x - v.x) + (v.y - v.y) + (v.z - v.z) == 0.0F;
}

inline double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }

DCM_HD inline Vec3d toDouble(const Vec3f& v) { return {v.x, v.y, v.z}; }
DCM_HD inline Vec3f toFloat(const Vec3d& v) { return {toFloat(v.x), toFloat(v.y), toFloat(v.z)}; }

}  // namespace deformable_contact_monitor
