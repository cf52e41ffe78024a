// Prepares the part of a bounded cycle that an exact detector does. It makes the detector's scene,
// and joins the detector's result with the contacts that were found by tiles.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <utility>
#include <vector>

#include "core/bounds/pair_rounds.h"
#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Owns a copy of the scene that has only some of its pairs. What did not change since the last
// cycle is not copied again, and pairs that stay the same keep their revision, so the warm-start
// data of detectors stays valid.
class ExactPart {
 public:
  // `memory`: where vertices are stored. It must outlive this object.
  explicit ExactPart(std::pmr::memory_resource& memory) : memory_(&memory) {}

  // Returns a scene with these pairs alone, (a, b) with a <= b, ascending; valid until the next
  // call. Bodies keep their ids. Bodies without a pair have no triangles, and none has an earlier
  // state, because the scene is for one moment.
  const Scene& sceneOf(const Scene& scene, const std::vector<std::pair<BodyId, BodyId>>& pairs);

 private:
  // The revisions of a body when it was last copied.
  struct Copied {
    std::uint64_t topology_revision = 0, vertices_revision = 0;  // 0: nothing was copied
  };

  void copy(const Body& body, BodyId id);

  std::pmr::memory_resource* memory_;
  Scene part_;
  std::vector<Copied> copied_;  // per body
};

// Copies the exact detector's result of these pairs into `result`, which has only stage times so
// far. Adds the distance of each pair of two different bodies, as far as the list of contacts tells
// it.
void takeExactResult(const Scene& scene, const std::vector<std::pair<BodyId, BodyId>>& pairs,
                     const DetectionResult& exact, DetectionResult& result);

// Adds contacts, sorted, of pairs of bodies of which `result` has none. Makes their geometry if the
// options ask for it; the vertices of their bodies must be on the host.
void mergeContacts(const Scene& scene, const Options& options,
                   const std::vector<ListedContact>& contacts, DetectionResult& result);

}  // namespace deformable_contact_monitor
