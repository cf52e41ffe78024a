// Patches that keep their ids from cycle to cycle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/analysis/contact_patches.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// One thread at a time.
class PatchTracker {
 public:
  // Gives each patch an id: that of the patch of the same two bodies, as they were last looked at,
  // with which it has most triangles in common, and at least one. A patch has one id and an id one
  // patch: the pairs with most in common are served first (then the lesser id, then the patch that
  // comes first), so that of a patch that falls apart the larger part keeps the id, and where
  // patches grow together the larger one's stays. Others have ids of their own that count up from
  // 1 and do not come again. Sorts the patches by bodies, then by id.
  // `patches`: all those of the scene's enabled pairs. What is known of a pair of bodies that is
  // not enabled stays, and is forgotten when the triangles of one of them change.
  void assign(const Scene& scene, std::vector<Patch>* patches);

  // What is known is forgotten.
  void forget() { known_.clear(); }

 private:
  // Of a body with itself, all in `a`.
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
