// The definition of a contact between two states, in exact integers: what swept detection is held
// against. Each vertex moves on a straight line from its place in state 0 (time 0) to that in state
// 1 (time 1), in real numbers; a triangle is the closed convex hull of its vertices at each time.
// Exact for all finite input; slow.
#pragma once

#include <gmpxx.h>

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/detector.h"
#include "core/options.h"
#include "core/predicates/triangle.h"
#include "core/scene.h"
#include "moving_points.h"

namespace deformable_contact_monitor {

// The first time is in [low, high], which is at most 2^-30 long; low == high is the time itself.
struct SweptTime {
  mpq_class low, high;
  // True if the triangles are in contact at the first time. If false, the first time is an infimum:
  // they are in contact right after it, but not at it. Only pairs that share a vertex can be so.
  bool is_attained;
};

// Triangles a and b of different bodies: whether their hulls intersect at some time in [0, 1]. A
// triangle with a vertex that is not finite in either state has no contact.
bool sweptContact(const Triangle& a0, const Triangle& a1, const Triangle& b0, const Triangle& b1);
std::optional<SweptTime> firstSweptContact(const Triangle& a0, const Triangle& a1,
                                           const Triangle& b0, const Triangle& b1);

// Triangles of one body: vertices with equal coordinates in state 0 and in state 1 are shared.
// Pairs that share some are left out (skip), or are a contact iff at some time they intersect
// beyond the convex hull of the shared points at that time (beyond_shared).
bool sweptContact(const Triangle& a0, const Triangle& a1, const Triangle& b0, const Triangle& b1,
                  AdjacentPairs adjacent);
std::optional<SweptTime> firstSweptContact(const Triangle& a0, const Triangle& a1,
                                           const Triangle& b0, const Triangle& b1,
                                           AdjacentPairs adjacent);

// Returns whether p meets the closed triangle abc at some time. `points` is {p, a, b, c}.
bool vertexFaceMeets(const std::array<Trajectory, 4>& points);

// Returns whether the closed segments pq and ab meet at some time. `points` is {p, q, a, b}.
bool edgeEdgeMeets(const std::array<Trajectory, 4>& points);

// Every swept contact of the enabled pairs of state 1, sorted, each once. Margins are ignored.
std::vector<TrianglePair> oracleSweptContacts(const Scene& state0, const Scene& state1,
                                              AdjacentPairs adjacent);

// When each of these contacts, as oracleSweptContacts gives them, is first.
std::vector<SweptTime> oracleFirstTimes(const Scene& state0, const Scene& state1,
                                        const std::vector<TrianglePair>& contacts);

// Every swept contact of one body with itself, the lesser triangle first. The meshes have the same
// triangles.
std::set<std::pair<std::uint32_t, std::uint32_t>> sweptPairs(const TriangleMesh& state0,
                                                             const TriangleMesh& state1,
                                                             AdjacentPairs adjacent);

}  // namespace deformable_contact_monitor
