#include "reference/fcl_closest_points.h"

#include <fcl/narrowphase/detail/primitive_shape_algorithm/triangle_distance.h>

namespace deformable_contact_monitor {
namespace {

fcl::Vector3d toFcl(const Vec3f& v) { return {v.x, v.y, v.z}; }

Vec3d fromFcl(const fcl::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

FclClosestPoints fclClosestPoints(const Triangle& a, const Triangle& b) {
  const fcl::Vector3d of_a[3] = {toFcl(a.v[0]), toFcl(a.v[1]), toFcl(a.v[2])};
  const fcl::Vector3d of_b[3] = {toFcl(b.v[0]), toFcl(b.v[1]), toFcl(b.v[2])};
  fcl::Vector3d on_a, on_b;
  const double distance =
      fcl::detail::TriangleDistance<double>::triDistance(of_a, of_b, on_a, on_b);
  return {fromFcl(on_a), fromFcl(on_b), distance};
}

}  // namespace deformable_contact_monitor
