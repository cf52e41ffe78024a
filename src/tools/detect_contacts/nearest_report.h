// Makes the outputs of --nearest: how far the bodies are apart, and where they are nearest.
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// What a detection says of the distances of bodies.
struct NearestBodies {
  // A pair of two bodies that is at most its margin apart.
  struct Entry {
    NearestPair nearest;
    bool is_exact;  // false: the distance is an upper bound, with --tolerance-m or has_rejected
    bool has_rejected = false;  // triangles of one of the two took no part, and may be nearer
  };

  std::vector<Entry> entries;  // ascending by (body_a, body_b)
  std::size_t open_pairs = 0;  // pairs that were not decided, so they have no entry
};

// Returns line(i) for each of the first 20 of `count` pairs of bodies, because a scene of many
// bodies has many, and how many more there are.
std::string firstPairs(std::size_t count, const std::function<std::string(std::size_t)>& line);

// Collects the pairs from the exact search and, if there is a tolerance, from the bounds of
// distances. A pair of bodies without an entry is farther apart than its margin, unless
// `open_pairs` counts it. Those of a body with rejected triangles are always counted.
NearestBodies nearestBodies(const Scene& scene, const DetectionResult& result, float tolerance_m);

// Returns a line "bodyA triA bodyB triB distance" for each entry. Numbers have nine digits, which
// restore the float32.
std::string nearestLines(const NearestBodies& bodies);

// Returns [{bodies, triangles, distance, exact, points, normal}].
nlohmann::json nearestJson(const NearestBodies& bodies);

// Returns a line for each of the first 20 entries, for people.
std::string nearestSummary(const Scene& scene, const NearestBodies& bodies);

// Returns what the entries alone do not show, a line each: pairs that are not decided, and
// distances that are bounds.
std::vector<std::string> nearestNotes(const NearestBodies& bodies, float tolerance_m);

}  // namespace deformable_contact_monitor
