// The definition of a contact on CGAL's exact predicates: what every detector is held against.
#pragma once

#include <vector>

#include "core/detector.h"
#include "core/options.h"
#include "core/predicates/triangle.h"
#include "core/scene.h"
#include "exact_clip.h"

namespace deformable_contact_monitor {

// As meetBeyondByConstruction, by exact predicates where no triangle is degenerate: fast.
bool meetBeyondByPredicates(const OracleTriangle& a, const OracleTriangle& b,
                            const std::vector<Vec3f>& shared);

// Every contact of the scene's enabled pairs, sorted, each once. Margins are ignored. It shares
// the scene, and the rounding of poses, with the detectors, and nothing else.
std::vector<TrianglePair> oracleContacts(const Scene& scene, AdjacentPairs adjacent);

// Pairs of one body's triangles without a shared vertex, or of different enabled bodies, whose
// closed AABBs overlap.
std::size_t oracleBoxPairs(const Scene& scene);

// Distance [m] of two nondegenerate triangles, up to double rounding.
double oracleDistance(const Triangle& a, const Triangle& b);

}  // namespace deformable_contact_monitor
