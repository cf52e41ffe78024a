#include "core/bounds/ways_along_mesh.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <tuple>

#include "core/common/posed_body.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();

}  // namespace

// A vertex that is not finite has a place of its own.
WaysAlongMesh::WaysAlongMesh(const Body& body) {
  const PosedBody posed(body);
  std::map<std::tuple<float, float, float>, std::uint32_t> known;
  std::vector<Vec3f> places;
  std::vector<std::uint32_t> place_of(body.mesh.vertexCount());
  for (std::size_t i = 0; i < place_of.size(); ++i) {
    const Vec3f v = posed.vertex(i);
    place_of[i] = static_cast<std::uint32_t>(places.size());
    if (isFinite(v)) {
      place_of[i] = known.emplace(std::make_tuple(v.x, v.y, v.z), place_of[i]).first->second;
    }
    if (place_of[i] == places.size()) places.push_back(v);
  }
  for (const std::uint32_t corner : body.mesh.triangles) corners_.push_back(place_of[corner]);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;
  for (std::size_t t = 0; t < corners_.size(); t += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = corners_[t + k], b = corners_[t + (k + 1) % 3];
      if (a == b) continue;
      ends.emplace_back(a, b);
      ends.emplace_back(b, a);
    }
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  first_edge_.assign(places.size() + 1, 0);
  for (const auto& [from, to] : ends) {
    ++first_edge_[from + 1];
    const bool is_known = isFinite(places[from]) && isFinite(places[to]);
    edges_.push_back({to, is_known ? length(toDouble(places[from]) - toDouble(places[to])) : 0});
  }
  for (std::size_t i = 0; i < places.size(); ++i) first_edge_[i + 1] += first_edge_[i];
  way_m_.assign(places.size(), kNowhere);
}

// Dijkstra's algorithm, up to the limit.
void WaysAlongMesh::startAt(std::uint32_t triangle, double limit_m) {
  for (const std::uint32_t place : found_) way_m_[place] = kNowhere;
  found_.clear();
  const auto reach = [&](std::uint32_t place, double way_m) {
    if (!(way_m < limit_m) || way_m >= way_m_[place]) return;
    if (way_m_[place] == kNowhere) found_.push_back(place);
    way_m_[place] = way_m;
    queue_.emplace_back(way_m, place);
    std::push_heap(queue_.begin(), queue_.end(), std::greater<>());
  };
  for (std::size_t k = 0; k < 3; ++k) reach(corners_[3 * std::size_t{triangle} + k], 0);
  while (!queue_.empty()) {
    std::pop_heap(queue_.begin(), queue_.end(), std::greater<>());
    const auto [way_m, place] = queue_.back();
    queue_.pop_back();
    if (way_m > way_m_[place]) continue;
    for (std::uint32_t e = first_edge_[place]; e < first_edge_[place + 1]; ++e) {
      reach(edges_[e].to, way_m + edges_[e].length_m);
    }
  }
}

bool WaysAlongMesh::reaches(std::uint32_t triangle) const {
  const std::uint32_t* const corners = &corners_[3 * std::size_t{triangle}];
  return std::any_of(corners, corners + 3,
                     [this](std::uint32_t place) { return way_m_[place] != kNowhere; });
}

}  // namespace deformable_contact_monitor
