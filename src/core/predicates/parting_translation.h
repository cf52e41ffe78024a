// Finds the shortest translation that separates two intersecting triangles.
//
// b moved by t still touches a iff t lies in the Minkowski difference {x - y: x in a, y in b}.
// Where that is a body, the shortest way out goes through one of its faces. The normals of its
// faces are those of the two triangles, and the products of an edge of a with an edge of b that
// both lie on the face. Exact signs decide which products these are, and the distance of a face is
// a quotient of determinants. So the length is right to 2^-27 of itself, however flat the triangles
// are and however far their vertices.
#pragma once

#include <cmath>

#include "core/host_device.h"
#include "core/predicates/contact_determinants.h"
#include "core/predicates/intersection_segment.h"

namespace deformable_contact_monitor {

struct PartingTranslation {
  Vec3d direction;     // of b; a unit vector
  double length = 0;   // [m]
  bool unique = true;  // no other direction has one that is as short within 2^-22
};

namespace detail {

DCM_HD inline Vec3d unit(const Vec3d& v) { return v * (1 / sqrt(dot(v, v))); }

DCM_HD DCM_RARE inline double expandedRise(const Triangle& t, const Vec3f& p, const Vec3f& q) {
  Expansion<72> sum;
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    const Vec3d u = toDouble(t.v[i]), v = toDouble(t.v[i == 2 ? 0 : i + 1]);
    addDeterminant(sum, u, v, toDouble(q), 1);
    addDeterminant(sum, u, v, toDouble(p), -1);
  }
  return sum.value();
}

DCM_HD DCM_RARE inline double exactRise(const Triangle& t, const Vec3f& p, const Vec3f& q) {
  if (isVertexOf(t, p) && isVertexOf(t, q)) return 0;  // common in layers of cloth
  double value = 0;
  const bool is_found = determinantByIntegers(t.v[0], t.v[1], t.v[0], t.v[2], p, q, value);
  return is_found ? value : expandedRise(t, p, q);
}

// Returns by how much q is higher above the plane of t than p, in units of its normal; right to
// 2^-29 of itself, and in the sign.
DCM_HD inline double riseOver(const Triangle& t, const Vec3f& p, const Vec3f& q) {
  const Vec3d u = toDouble(t.v[1]) - toDouble(t.v[0]), v = toDouble(t.v[2]) - toDouble(t.v[0]);
  const Vec3d w = toDouble(q) - toDouble(p);
  const double m1 = v.y * w.z, m2 = v.z * w.y, m3 = v.z * w.x;
  const double m4 = v.x * w.z, m5 = v.x * w.y, m6 = v.y * w.x;
  const double rise = u.x * (m1 - m2) + u.y * (m3 - m4) + u.z * (m5 - m6);
  const double terms = fabs(u.x) * (fabs(m1) + fabs(m2)) + fabs(u.y) * (fabs(m3) + fabs(m4)) +
                       fabs(u.z) * (fabs(m5) + fabs(m6));
  return fabs(rise) >= kEnough * terms ? rise : exactRise(t, p, q);
}

// Keeps the nearest of the faces that were added.
struct NearestFace {
  Vec3d normal;
  double squared = INFINITY;
  bool unique = true;

  // Adds a face at `distance`, in units of its normal, which points outwards.
  DCM_HD void add(const Vec3d& face_normal, double distance) {
    constexpr double kAsShort = 1 + 0x1p-21;  // squared
    const double size2 = dot(face_normal, face_normal);
    if (!(size2 > 0)) return;
    const double squared_here = distance > 0 ? distance * distance / size2 : 0;
    if (squared_here > squared * kAsShort) return;
    if (squared_here * kAsShort < squared) {
      unique = true;
    } else if (unique) {
      unique = isSameDirection(face_normal, normal);
    }
    if (squared_here >= squared) return;
    squared = squared_here;
    normal = face_normal;
  }

  DCM_HD static bool isSameDirection(const Vec3d& a, const Vec3d& b) {
    constexpr double kSame = 1e-12;
    const Vec3d apart = unit(a) - unit(b);
    return dot(apart, apart) < kSame;
  }

  // Adds both faces along the normal of a triangle. `height` has the heights of the other's
  // vertices above its plane. `sign` says on which side the triangle with that plane is to be left.
  DCM_HD void addPlane(const Vec3d& plane_normal, const double height[3], double sign) {
    const double top = most(height[0], most(height[1], height[2]));
    const double bottom = least(height[0], least(height[1], height[2]));
    add(plane_normal * sign, -bottom);
    add(plane_normal * -sign, top);
  }
};

}  // namespace detail

// Returns the translation for a and b that intersect, are not in one plane, and of which at least
// one has area.
DCM_HD inline PartingTranslation partingTranslation(const Triangle& a, const Triangle& b,
                                                    const Heights& heights) {
  detail::NearestFace nearest;
  const auto next = [](int i) { return i == 2 ? 0 : i + 1; };
  // b leaves a's plane upwards once its lowest vertex does; a does the same downwards from b's
  // plane.
  nearest.addPlane(detail::contactCross(a.v[0], a.v[1], a.v[1], a.v[2]), heights.of_b, 1);
  nearest.addPlane(detail::contactCross(b.v[0], b.v[1], b.v[1], b.v[2]), heights.of_a, -1);
  double rise_of_b[3], rise_of_a[3];
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    rise_of_b[i] = detail::riseOver(a, b.v[i], b.v[next(i)]);
    rise_of_a[i] = detail::riseOver(b, a.v[i], a.v[next(i)]);
  }
  DCM_ROLLED for (int i = 0; i < 3; ++i) {
    DCM_ROLLED for (int j = 0; j < 3; ++j) {
      // If neither triangle reaches beyond both edges, seen along their product, the two edges make
      // a face.
      const int sign_a = signOf(rise_of_a[i]), sign_b = signOf(rise_of_b[j]);
      if (sign_a * sign_b < 0 || (sign_a == 0 && sign_b == 0)) continue;
      const double sign = sign_a != 0 ? sign_a : sign_b;
      const Vec3f &p = a.v[i], &q = a.v[next(i)], &r = b.v[j], &s = b.v[next(j)];
      nearest.add(detail::contactCross(p, q, r, s) * sign,
                  sign * detail::contactVolume(p, q, r, s));
    }
  }
  return {detail::unit(nearest.normal), sqrt(nearest.squared), nearest.unique};
}

}  // namespace deformable_contact_monitor
