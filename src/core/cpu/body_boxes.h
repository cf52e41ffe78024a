// Where the bodies of a scene are.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/cycle_limit.h"
#include "core/predicates/aabb.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// The boxes of a body's partners that meet its own.
struct PartnerBoxes {
  bool self = false;  // it is its own partner: every triangle counts
  Aabb hull;
  std::vector<Aabb> boxes;

  bool meet(const Aabb& box) const {
    if (self) return true;
    return intersects(hull, box) &&
           std::any_of(boxes.begin(), boxes.end(),
                       [&box](const Aabb& partner) { return intersects(partner, box); });
  }
};

// Keeps the boxes of bodies whose vertices did not change from call to call.
class BodyBoxes {
 public:
  // Of all bodies that take part; the others' are of no use.
  void update(const Scene& scene, const CycleLimit& limit);

  PartnerBoxes partnersOf(const Scene& scene, BodyId id) const;

  // Whether every vertex is certainly finite, as received and as posed.
  bool allFinite(BodyId id) const { return all_finite_[id]; }

 private:
  struct ReceivedBox {
    std::uint64_t vertices_revision = 0;  // none has 0
    Aabb box;                             // of the finite vertices, body frame [m]
    bool all_finite = true;
  };

  std::vector<ReceivedBox> received_;
  // Each holds every finite vertex of its body as posed in float32, grown by the body's margin [m].
  std::vector<Aabb> posed_;
  std::vector<bool> all_finite_;  // of each body
};

}  // namespace deformable_contact_monitor
