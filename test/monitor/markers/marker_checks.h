// Provides what the tests of markers share: rviz's checks of markers, and the list of actions.
#pragma once

#include <gtest/gtest.h>
#include <visualization_msgs/MarkerArray.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

// 0: not a type that this package draws.
inline std::size_t pointsEach(std::int32_t type) {
  switch (type) {
    case Marker::TRIANGLE_LIST:
      return 3;
    case Marker::LINE_LIST:
      return 2;
    case Marker::SPHERE_LIST:
      return 1;
    default:
      return 0;
  }
}

inline bool isDrawable(const std_msgs::ColorRGBA& c) {
  return std::isfinite(c.r + c.g + c.b) && c.a > 0 && c.a <= 1;
}

// rviz's checkMarkerMsg and checkMarkerArrayMsg for what this package draws.
inline void expectValid(const MarkerArray& array) {
  std::set<std::pair<std::string, int>> ids;
  for (std::size_t i = 0; i < array.markers.size(); ++i) {
    const Marker& m = array.markers[i];
    SCOPED_TRACE("marker " + std::to_string(i) + " " + m.ns);
    EXPECT_TRUE(m.action != Marker::DELETEALL || i == 0);
    EXPECT_FALSE(m.header.frame_id.empty());
    EXPECT_EQ(m.pose.orientation.w, 1);
    EXPECT_EQ(m.pose.orientation.x, 0);
    EXPECT_TRUE(ids.insert({m.ns, m.id}).second);
    if (m.action != Marker::ADD) continue;
    if (m.type == Marker::TEXT_VIEW_FACING) {
      EXPECT_FALSE(m.text.empty());
      EXPECT_GT(m.scale.z, 0);
      continue;
    }
    const std::size_t points_each = pointsEach(m.type);
    ASSERT_NE(points_each, 0U) << "type " << m.type;
    EXPECT_GT(m.scale.x * m.scale.y * m.scale.z, 0);
    EXPECT_GT(m.lifetime.toSec(), 0);
    EXPECT_FALSE(m.points.empty());
    EXPECT_EQ(m.points.size() % points_each, 0U);
    EXPECT_TRUE(m.colors.empty() || m.colors.size() == m.points.size());
    EXPECT_TRUE(isDrawable(m.color));
    for (const auto& c : m.colors) EXPECT_TRUE(isDrawable(c));
    for (const auto& p : m.points) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
  }
}

// "<namespace>" drawn, "-<namespace>" deleted, "all" for DELETEALL.
inline std::vector<std::string> actions(const MarkerArray& array) {
  std::vector<std::string> lines;
  for (const Marker& m : array.markers) {
    lines.push_back(m.action == Marker::ADD      ? m.ns
                    : m.action == Marker::DELETE ? "-" + m.ns
                                                 : "all");
  }
  return lines;
}

using Actions = std::vector<std::string>;

}  // namespace deformable_contact_monitor
