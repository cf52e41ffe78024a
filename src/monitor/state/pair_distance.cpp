// How far apart the bodies of a pair are, where a bounded detection says it.
#include "monitor/state/pair_distance.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace deformable_contact_monitor {

Vec3d PairDistance::centroid() const {
  return (toDouble(bounds->point_a) + toDouble(bounds->point_b)) * 0.5;
}

Vec3d PairDistance::normal() const {
  constexpr double kRounding = 0x1p-20;  // of the points, by their largest coordinate
  const Vec3d a = toDouble(bounds->point_a), b = toDouble(bounds->point_b);
  double largest = 0;
  for (const Vec3d& v : {a, b}) {
    largest = std::max({largest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  }
  const Vec3d way = b - a;
  const double length = std::sqrt(dot(way, way));
  if (bounds->high_m == 0 || length <= kRounding * largest) return {};
  return way * (1 / length);
}

std::optional<PairDistance> distanceOf(const CycleReport& report, const MonitoredPair& pair,
                                       float tolerance_m) {
  if (report.result == nullptr) return std::nullopt;
  const std::vector<BodyDistance>& all = report.result->distances;
  const auto found = std::lower_bound(
      all.begin(), all.end(), pair, [](const BodyDistance& one, const MonitoredPair& of) {
        return std::tie(one.body_a, one.body_b) < std::tie(of.a, of.b);
      });
  if (found == all.end() || found->body_a != pair.a || found->body_b != pair.b) {
    return std::nullopt;
  }
  const float margin_m =
      std::max(report.scene->body(pair.a).margin_m, report.scene->body(pair.b).margin_m);
  return PairDistance{&*found, decide(*found, margin_m, tolerance_m)};
}

}  // namespace deformable_contact_monitor
