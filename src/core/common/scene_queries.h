// Questions about a scene that several backends ask before or after a cycle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/export.h"
#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Groups of bodies that may touch the same bodies. Sweeps run over pairs of groups, so that they
// never visit a pair of bodies that is disabled.
struct DCM_EXPORT BodyGroups {
  std::vector<std::uint32_t> group;        // per body
  std::vector<std::vector<bool>> enabled;  // per pair of groups

  // Two bodies are in the same group iff their rows of enabled pairs are equal. So all pairs of
  // bodies from two given groups, or from one, are enabled, or none is.
  explicit BodyGroups(const Scene& scene);
};

// Returns the number of triangles of the bodies that take part.
DCM_EXPORT std::size_t trianglesThatTakePart(const Scene& scene);

// Returns whether contacts include pairs of triangles that are near, but do not touch.
DCM_EXPORT bool listsNearPairs(const Scene& scene, const Options& options);

// Returns the margin within which near pairs of the body's triangles are listed [m]: its own, or 0.
DCM_EXPORT float listedMargin(const Body& body, const Options& options);

// Throws std::invalid_argument, naming the body and the backend, if a body that takes part has its
// vertices on a device. For backends that cannot read device memory.
void requireHostVertices(const Scene& scene, const std::string& backend);
// Does the same for one body that takes part.
void requireHostVertices(const Body& body, const std::string& backend);

// The triangles of a body that take no part because one of their vertices is not finite.
struct RejectedTriangles {
  std::size_t count = 0;  // Counters::rejected is the sum over all bodies
  bool by_pose = false;   // some vertex was received finite, and its pose makes it infinite
  std::vector<std::size_t> by_part;  // of bodies with named parts: `count` by part, from 0 on
};

// Returns one entry per body of the scene, zero for bodies that take no part. Triangles of parts
// that take no part do not count. In swept motion it looks at both states. Reads every vertex, so
// call it only after a cycle that rejected triangles.
std::vector<RejectedTriangles> rejectedTriangles(const Scene& scene,
                                                 Motion motion = Motion::kInstant);

}  // namespace deformable_contact_monitor
