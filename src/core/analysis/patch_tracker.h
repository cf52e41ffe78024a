// Gives patches ids that stay the same from cycle to cycle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/analysis/contact_patches.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Remembers the patches of the last call, and recognises them in the next. One thread at a time.
class PatchTracker {
 public:
  // Gives each patch the id of that patch of the same two bodies, in the last call, with which it
  // has most triangles in common, if it has any. Each id goes to one patch only: matches with most
  // triangles in common come first (then the lesser id, then the earlier patch). So if a patch
  // splits, its larger part keeps the id, and if patches merge, the larger one's id stays. All
  // other patches get new ids, which count up from 1 and are never used again. Sorts the patches by
  // bodies, then by id. `patches` must be all patches of the scene's enabled pairs. Pairs of bodies
  // that are not enabled keep their ids until the triangles of one of the bodies change.
  void assign(const Scene& scene, std::vector<Patch>* patches);

  // Forgets all ids given so far, but never gives one of them again.
  void forget() { known_.clear(); }

 private:
  // The triangles of a patch. Of a body with itself, all are in `a`.
  struct Triangles {
    std::vector<std::uint32_t> a, b;
  };
  struct KnownPatch {
    std::uint32_t id = 0;
    Triangles triangles;
  };
  struct KnownPair {
    std::uint64_t topology_a = 0, topology_b = 0;  // revisions
    std::vector<KnownPatch> patches;
  };
  // Counts the triangles that a known patch and a new one have in common.
  struct Overlap {
    std::size_t triangles = 0;
    std::uint32_t id = 0;  // of a known patch
    std::size_t patch = 0;
  };

  static Triangles trianglesOf(const Patch& patch);
  void assignOfPair(const Scene& scene, KnownPair* known, Patch* begin, Patch* end);
  std::vector<Overlap> overlaps(const std::vector<KnownPatch>& known,
                                const std::vector<Triangles>& patches);

  std::map<std::pair<BodyId, BodyId>, KnownPair> known_;
  std::vector<std::uint32_t> owner_a_, owner_b_;  // by triangle; kNone between uses
  std::uint32_t last_id_ = 0;
};

}  // namespace deformable_contact_monitor
