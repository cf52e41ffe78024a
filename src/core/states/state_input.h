// What a batch of states asks of a scene: which pairs of bodies are looked at, and which triangles
// take no part. Both backends begin with it.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/export.h"
#include "core/scene.h"
#include "core/state_checker.h"

namespace deformable_contact_monitor {

// Throws std::invalid_argument, as StateChecker::check() says, but for vertices on a device.
DCM_EXPORT void requireValid(const Scene& scene, const StateBatch& batch);

// Returns the enabled pairs (a, b), a < b, of two bodies of which one is moved, ascending.
DCM_EXPORT std::vector<std::pair<BodyId, BodyId>> pairsOfStates(const Scene& scene,
                                                                const StateBatch& batch);

// Returns whether a part of a body is in an enabled pair of parts with a body of these pairs.
DCM_EXPORT bool partTakesPart(const Scene& scene,
                              const std::vector<std::pair<BodyId, BodyId>>& pairs, BodyId body,
                              PartId part);

// Counts triangles whose vertices were not received finite, and keeps the counts as long as
// vertices and parts of a body stay the same. One thread at a time.
class DCM_EXPORT RejectedCounts {
 public:
  // Returns StateResults::rejected for these pairs. The vertices must be on the host.
  std::vector<RejectedPart> of(const Scene& scene,
                               const std::vector<std::pair<BodyId, BodyId>>& pairs);

 private:
  struct Counted {
    std::uint64_t vertices_revision = 0, parts_revision = 0;
    std::vector<RejectedPart> parts;
  };
  std::vector<Counted> of_body_;
};

// Returns whether a pose makes a vertex of some triangle infinite, of a triangle whose vertices
// were received finite. Reads all vertices, which must be on the host; where posedBox() of the
// body's box is finite, the answer is no.
DCM_EXPORT bool leavesFloats(const Body& body, const RigidTransform& pose);

}  // namespace deformable_contact_monitor
