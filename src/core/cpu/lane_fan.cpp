#include "core/cpu/lane_fan.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/cpu/lane_product.h"

namespace deformable_contact_monitor {
namespace {

LanePoint spread(const Vec3f& p, const Vec3f& q, const Vec3f& r, const Vec3f& s) {
  return {FloatLanes{p.x, q.x, r.x, s.x}, FloatLanes{p.y, q.y, r.y, s.y},
          FloatLanes{p.z, q.z, r.z, s.z}};
}

std::uint32_t ringSize(const VertexFans& fans, std::uint32_t v) {
  return fans.begin[v + 1] - fans.begin[v];
}

bool isClosed(const VertexFans& fans, std::uint32_t v) {
  return fans.ring[fans.begin[v]] == fans.ring[fans.begin[v + 1] - 1];
}

constexpr std::uint32_t kMostRing = 33;  // points of a ring that is a fan's

}  // namespace

std::vector<std::uint32_t> foursAlike(const VertexFans& fans) {
  std::array<std::vector<std::uint32_t>, 2 * (kMostRing + 1)> kinds;
  const auto count = static_cast<std::uint32_t>(fans.begin.size()) - 1;
  for (std::uint32_t v = 0; v < count; ++v) {
    const std::uint32_t size = ringSize(fans, v);
    if (size < 2 || size > kMostRing || fans.ring[fans.begin[v]] == v) continue;
    kinds[2 * size + (isClosed(fans, v) ? 1 : 0)].push_back(v);
  }
  std::vector<std::uint32_t> fours;
  for (const std::vector<std::uint32_t>& kind : kinds) {
    fours.insert(fours.end(), kind.begin(), kind.end());
    while (fours.size() % 4 != 0) fours.push_back(kind.back());
  }
  return fours;
}

IntLanes areFansCertified(const VertexFans& fans, const std::uint32_t four[4],
                          const Vec3f* vertices) {
  const std::uint32_t size = ringSize(fans, four[0]);
  const std::uint32_t last = isClosed(fans, four[0]) ? size - 1 : size;
  const LanePoint centre =
      spread(vertices[four[0]], vertices[four[1]], vertices[four[2]], vertices[four[3]]);
  const std::uint32_t* ring[4];
  for (int i = 0; i < 4; ++i) ring[i] = &fans.ring[fans.begin[four[i]]];
  LanePoint to[kMostRing];
  LaneProduct product[kMostRing];
  LanePoint normal{};
  for (std::uint32_t k = 0; k < size; ++k) {
    to[k] = spread(vertices[ring[0][k]], vertices[ring[1][k]], vertices[ring[2][k]],
                   vertices[ring[3][k]]) -
            centre;
    if (k == 0) continue;
    product[k] = LaneProduct(to[k - 1], to[k]);
    const LanePoint& value = product[k].value();
    normal = {normal.x + value.x, normal.y + value.y, normal.z + value.z};
  }
  constexpr auto sizeOf = LaneProduct::sizeOf;
  const FloatLanes scale = most(most(sizeOf(normal.x), sizeOf(normal.y)), sizeOf(normal.z));
  const FloatLanes share = 1 / scale;
  normal = {normal.x * share, normal.y * share, normal.z * share};
  IntLanes certified = ~IntLanes{}, ahead{};
  for (std::uint32_t k = 1; k < size; ++k) {
    certified &= product[k].signWith(normal).positive;
    if (k >= last) continue;
    const LaneSigns side = LaneProduct(to[0], to[k]).signWith(normal);
    if (k > 1) certified &= ahead | side.negative;
    ahead = side.positive;
  }
  return certified;
}

}  // namespace deformable_contact_monitor
