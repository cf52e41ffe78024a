// Random parts of bodies and random rules for them, and what brute force finds without parts,
// filtered by these rules.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "core/common/posed_body.h"
#include "core/scene.h"
#include "detector_suite.h"

namespace deformable_contact_monitor {

inline bool operator!=(const NearestOfParts& x, const NearestOfParts& y) { return !(x == y); }

inline PartId partOf(const Scene& scene, BodyId id, std::uint32_t triangle) {
  const std::vector<PartId>& parts = scene.body(id).parts;
  return parts.empty() ? PartId{0} : parts[triangle];
}

// Divides most bodies into parts, triangle by triangle or in runs, and disables a third of the
// pairs of parts, or nearly all. Some rules are for parts that no triangle has.
inline void divide(Scene& scene, std::uint32_t seed) {
  std::mt19937 random(seed);
  const std::size_t most = 1 + random() % 5;
  const bool in_runs = random() % 2 == 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (random() % 4 == 0) continue;
    const std::size_t count = scene.body(id).mesh.triangleCount();
    std::vector<PartId> parts;
    for (std::size_t t = 0; t < count; ++t) {
      const std::size_t part = in_runs ? t * most / count : random() % most;
      parts.push_back(static_cast<PartId>(part * 51));
    }
    scene.setParts(id, parts);
  }
  const std::size_t one_in = random() % 4 == 0 ? 10 : 3;
  for (BodyId a = 0; a < scene.bodyCount(); ++a) {
    for (BodyId b = a; b < scene.bodyCount(); ++b) {
      for (std::size_t i = 0; i <= most; ++i) {
        for (std::size_t j = 0; j <= most; ++j) {
          const bool enabled = one_in == 10 ? random() % one_in == 0 : random() % one_in != 0;
          scene.setPartPairEnabled(a, static_cast<PartId>(i * 51), b, static_cast<PartId>(j * 51),
                                   enabled);
        }
      }
    }
  }
}

// Gives some parts margins of their own [m], larger and smaller ones than their body's.
inline void giveMargins(Scene& scene, std::uint32_t seed) {
  constexpr float kMargins[] = {0, 1e-40F, 0.02F, 0.1F, 0.3F, 2, 1e30F};
  std::mt19937 random(seed);
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    std::map<PartId, float> margins_m;
    for (PartId part = 0; part < 204 && random() % 3 != 0; part = static_cast<PartId>(part + 51)) {
      margins_m[part] = kMargins[random() % 7];
    }
    scene.setPartMargins(id, margins_m);
  }
}

// Returns the margin of a triangle [m].
inline float marginOf(const Scene& scene, BodyId id, std::uint32_t triangle) {
  const std::map<PartId, float>& own_m = scene.body(id).part_margins_m;
  const auto found = own_m.find(partOf(scene, id, triangle));
  return found == own_m.end() ? scene.body(id).own_margin_m : found->second;
}

// Returns the scene without parts and rules for them. Each body has the largest margin of its
// triangles.
inline Scene undivided(Scene scene) {
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    float most_m = 0;
    const std::size_t count = scene.body(id).mesh.triangleCount();
    for (std::uint32_t t = 0; t < count; ++t) most_m = std::max(most_m, marginOf(scene, id, t));
    scene.setPartMargins(id, {});
    scene.setMargin(id, most_m);
    scene.setParts(id, {});
  }
  scene.enableAllParts();
  return scene;
}

inline bool isCompared(const Scene& scene, const TrianglePair& pair) {
  return scene.partPairEnabled(pair.body_a, partOf(scene, pair.body_a, pair.triangle_a),
                               pair.body_b, partOf(scene, pair.body_b, pair.triangle_b));
}

// Keeps of a result's lists of contacts what the scene's parts leave.
inline DetectionResult filtered(const Scene& scene, const DetectionResult& all) {
  DetectionResult kept;
  for (std::size_t i = 0; i < all.contacts.size(); ++i) {
    const TrianglePair& pair = all.contacts[i];
    const float margin_m = std::max(marginOf(scene, pair.body_a, pair.triangle_a),
                                    marginOf(scene, pair.body_b, pair.triangle_b));
    if (!isCompared(scene, pair) || all.separationM(i) > margin_m) continue;
    kept.contacts.push_back(all.contacts[i]);
    if (!all.separations_m.empty()) kept.separations_m.push_back(all.separations_m[i]);
    if (!all.geometry.empty()) kept.geometry.push_back(all.geometry[i]);
    if (!all.first_times.empty()) kept.first_times.push_back(all.first_times[i]);
    if (!all.within_pad.empty()) kept.within_pad.push_back(all.within_pad[i]);
  }
  return kept;
}

// A body's triangles of one part, and their numbers in the body.
struct PartMesh {
  TriangleMesh mesh;
  std::vector<std::uint32_t> triangle;

  PartMesh(const Scene& scene, BodyId id, PartId part) {
    const TriangleMesh& whole = scene.body(id).mesh;
    mesh.vertices = whole.vertices;
    for (std::uint32_t t = 0; t < whole.triangleCount(); ++t) {
      if (partOf(scene, id, t) != part) continue;
      triangle.push_back(t);
      for (std::size_t k = 0; k < 3; ++k) mesh.triangles.push_back(whole.triangles[3 * t + k]);
    }
  }
};

// Returns the nearest pair of each enabled pair of parts of two bodies, by brute force on scenes of
// two meshes that have only these parts.
inline std::vector<NearestOfParts> nearestOfAllParts(const Scene& scene, Detector& brute_force,
                                                     Options options) {
  options.nearest_by_part = false;
  std::vector<NearestOfParts> all;
  for (const auto& [a, b] : scene.enabledPairs()) {
    if (a == b) continue;
    for (const PartId part_a : scene.body(a).listed_parts) {
      for (const PartId part_b : scene.body(b).listed_parts) {
        if (!scene.partPairEnabled(a, part_a, b, part_b)) continue;
        const PartMesh of_a(scene, a, part_a), of_b(scene, b, part_b);
        Scene alone;
        for (const auto& [id, mesh] : {std::make_pair(a, of_a.mesh), {b, of_b.mesh}}) {
          const BodyId copy = alone.addBody("part", mesh);
          alone.setPose(copy, scene.body(id).pose);
        }
        alone.setMargin(0, scene.body(a).marginOf(part_a));
        alone.setMargin(1, scene.body(b).marginOf(part_b));
        alone.setPairEnabled(0, 1, true);
        for (NearestPair nearest : brute_force.detect(alone, options).nearest) {
          nearest.pair = {a, of_a.triangle[nearest.pair.triangle_a], b,
                          of_b.triangle[nearest.pair.triangle_b]};
          all.push_back({{a, b, part_a, part_b}, nearest});
        }
      }
    }
  }
  std::sort(all.begin(), all.end(),
            [](const NearestOfParts& x, const NearestOfParts& y) { return x.parts < y.parts; });
  return all;
}

// Returns the nearest pair of each two bodies from those of their parts.
inline std::vector<NearestPair> nearestOfBodies(const std::vector<NearestOfParts>& of_parts) {
  std::map<std::pair<BodyId, BodyId>, NearestPair> least;
  const auto order = [](const NearestPair& n) {
    return std::make_tuple(n.distance_m, n.pair.triangle_a, n.pair.triangle_b);
  };
  for (const NearestOfParts& of : of_parts) {
    const NearestPair& nearest = of.nearest;
    const auto [place, is_new] =
        least.emplace(std::make_pair(nearest.pair.body_a, nearest.pair.body_b), nearest);
    if (!is_new && order(nearest) < order(place->second)) place->second = nearest;
  }
  std::vector<NearestPair> all;
  for (const auto& [bodies, nearest] : least) all.push_back(nearest);
  return all;
}

// Returns whether a part has an enabled pair with a part that triangles have.
inline bool partTakesPart(const Scene& scene, BodyId id, PartId part) {
  for (BodyId other = 0; other < scene.bodyCount(); ++other) {
    for (const PartId its : scene.body(other).listed_parts) {
      if (scene.partPairEnabled(id, part, other, its)) return true;
    }
  }
  return false;
}

// Counts rejected triangles: of all parts that take part, and of each part of bodies with named
// parts.
struct ExpectedRejected {
  std::uint64_t all = 0;
  std::vector<RejectedPart> by_part;

  ExpectedRejected(const Scene& scene, Motion motion) {
    std::map<std::pair<BodyId, PartId>, std::uint64_t> counts;
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      const Body& body = scene.body(id);
      const PosedBody now(body), earlier = PosedBody::earlier(body);
      for (std::uint32_t t = 0; t < body.mesh.triangleCount(); ++t) {
        const bool finite = isFinite(now.triangle(t)) &&
                            (motion == Motion::kInstant || isFinite(earlier.triangle(t)));
        if (finite || !partTakesPart(scene, id, partOf(scene, id, t))) continue;
        ++all;
        if (!body.parts.empty()) ++counts[{id, partOf(scene, id, t)}];
      }
    }
    for (const auto& [part, count] : counts) by_part.push_back({part.first, part.second, count});
  }
};

}  // namespace deformable_contact_monitor
