// Points and vectors as plain structs, for host and device.
#pragma once

#include <cmath>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// Return the lesser and the greater of two numbers. Unlike fmin and fmax they compile to one
// instruction. The result for NaN is unspecified, so callers exclude it.
template <class Real>
DCM_HD inline Real least(Real a, Real b) {
  return b < a ? b : a;
}
template <class Real>
DCM_HD inline Real most(Real a, Real b) {
  return a < b ? b : a;
}

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

struct Vec3f {
  float x = 0, y = 0, z = 0;

  DCM_HD float operator[](int axis) const { return axis == 0 ? x : (axis == 1 ? y : z); }
};

// Compares coordinates; -0 equals 0.
DCM_HD inline bool operator==(const Vec3f& a, const Vec3f& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}
DCM_HD inline bool operator!=(const Vec3f& a, const Vec3f& b) { return !(a == b); }
DCM_HD inline Vec3f operator-(const Vec3f& a, const Vec3f& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
DCM_HD inline Vec3f operator+(const Vec3f& a, const Vec3f& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
DCM_HD inline Vec3f operator*(const Vec3f& a, float s) { return {a.x * s, a.y * s, a.z * s}; }
DCM_HD inline float dot(const Vec3f& a, const Vec3f& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Returns whether all coordinates are finite. x - x is 0 for a finite x and NaN otherwise, so one
// comparison checks all three.
DCM_HD inline bool isFinite(const Vec3f& v) {
  return (v.x - v.x) + (v.y - v.y) + (v.z - v.z) == 0.0F;
}

struct Vec3d {
  double x = 0, y = 0, z = 0;
};

DCM_HD inline Vec3d toDouble(const Vec3f& v) { return {v.x, v.y, v.z}; }
DCM_HD inline Vec3f toFloat(const Vec3d& v) { return {toFloat(v.x), toFloat(v.y), toFloat(v.z)}; }
DCM_HD inline Vec3d operator-(const Vec3d& a, const Vec3d& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
DCM_HD inline Vec3d operator+(const Vec3d& a, const Vec3d& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
DCM_HD inline Vec3d operator*(const Vec3d& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
DCM_HD inline double dot(const Vec3d& a, const Vec3d& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
DCM_HD inline Vec3d cross(const Vec3d& a, const Vec3d& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace deformable_contact_monitor
