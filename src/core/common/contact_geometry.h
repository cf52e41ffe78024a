// Witness points, normals and depths of a result's contacts, computed on the host.
#pragma once

#include <vector>

#include "core/common/posed_body.h"
#include "core/detector.h"
#include "core/export.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Fills result.geometry, for all of result.contacts, on threads. Does nothing unless
// options.geometry is set. Leaves it empty if options.limits end the work before it is complete.
// The scene's vertices must be on the host.
void writeGeometry(const Scene& scene, const Options& options, DetectionResult& result);

// Return the nearest pair of two bodies whose nearest triangles are these, at that distance [m]: 0
// if they intersect. The vertices of both bodies must be on the host.
DCM_EXPORT NearestPair nearestPairOf(const Scene& scene, const TrianglePair& pair,
                                     float distance_m);
NearestPair nearestPairOf(const PosedBody& a, const PosedBody& b, const TrianglePair& pair,
                          float distance_m);

// Returns the nearest pairs of the bodies that touch, from a complete list of contacts: the first
// contact of each two bodies. `contacts` must be sorted. Pairs of a body with itself, and those
// that are only near, do not count.
std::vector<NearestPair> touchingPairs(const Scene& scene, const DetectionResult& result);

// Returns the same of each pair of parts of two bodies of which one has named parts, ascending.
DCM_EXPORT std::vector<NearestOfParts> touchingParts(const Scene& scene,
                                                     const DetectionResult& result);

}  // namespace deformable_contact_monitor
