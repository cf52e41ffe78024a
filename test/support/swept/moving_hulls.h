// When two convex hulls of moving points first meet: by minimal Radon partitions.
//
// Two hulls meet iff some circuit has its positive points in one and its negative points in the
// other. A circuit is a minimal affinely dependent set; its dependency, unique up to a factor, has
// no zero, and the hulls of its positive and its negative points meet in one point, inside both. (A
// common point is a dependency of the points with signs as asked for, and each dependency is a sum
// of circuits of the same signs.) In space circuits have two to five points: two that coincide, a
// point inside a segment or a triangle, two segments that cross, a segment through a triangle.
//
// Beyond the hull of the shared points S: the common point is an average of points of S and of the
// common points of such circuits. So all common points lie in S's hull iff the circuits' do.
//
// A circuit and its signs are known from signs of determinants of the points and of their
// projections, polynomials in time. Each circuit is looked at by itself: at all roots of those, and
// in between. Nothing is rounded, and no degenerate case is special.
#pragma once

#include <optional>
#include <vector>

#include "moving_points.h"

namespace deformable_contact_monitor {

// Points of each hull, by place in `points`; those in both are shared. At most three in each, no
// point's trajectory twice where some are shared.
struct MovingHulls {
  std::vector<Trajectory> points;
  PointSet a = 0, b = 0;
};

struct MeetingTime {
  AlgebraicTime time;
  bool is_attained;  // else they meet right after `time`, and not then
};

// The first time in [0, 1] when the closed hulls have a common point beyond the hull of the shared
// points, if there is one. Sharing none, they meet at `time` itself, as the times are a closed set.
std::optional<MeetingTime> firstMeeting(const MovingHulls& hulls);

// Returns whether firstMeeting() finds a time, and is faster.
bool meetEver(const MovingHulls& hulls);

}  // namespace deformable_contact_monitor
