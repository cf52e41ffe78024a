// Where the bodies of a scene are.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/primitive.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// The boxes of a body's partners that meet its own, Aabb or MovingBox.
template <class Box>
struct PartnerBoxes {
  bool self = false;  // it is its own partner: every triangle counts
  Box hull;
  std::vector<Box> boxes;

  bool meet(const Box& box) const {
    if (self) return true;
    return intersects(hull, box) &&
           std::any_of(boxes.begin(), boxes.end(),
                       [&box](const Box& partner) { return intersects(partner, box); });
  }
};

// Keeps the boxes of bodies whose vertices did not change from call to call.
class BodyBoxes {
 public:
  // Of all vertices; or, as far as some say where a body is, of no more than so many, evenly spread
  // over their order.
  BodyBoxes() = default;
  explicit BodyBoxes(std::size_t most_vertices) : most_vertices_(most_vertices) {}

  // Of all bodies that take part; the others' are of no use. Hull: as in hull.h.
  template <class Hull>
  void update(const Scene& scene, const CycleLimit& limit);

  // As updated with the same Hull.
  template <class Hull>
  PartnerBoxes<BoxOf<Hull>> partnersOf(const Scene& scene, BodyId id) const;

  // Whether every vertex was looked at and is certainly finite, as received and as posed, in all
  // states.
  bool allFinite(BodyId id) const { return all_finite_[id]; }

 private:
  struct ReceivedBox {
    std::uint64_t vertices_revision = 0;  // none has 0
    Aabb box;                             // of the finite vertices, body frame [m]
    bool all_finite = true;
  };

  bool updateReceived(std::uint64_t revision, const HostList<float>& xyz, const CycleLimit& limit,
                      ReceivedBox& received) const;

  std::size_t most_vertices_ = std::numeric_limits<std::size_t>::max();
  std::vector<ReceivedBox> received_, earlier_received_;
  // Each holds every finite vertex of its body that was looked at, as posed in float32, grown by
  // growthOf [m]. Without motion `to` alone is of use.
  std::vector<MovingBox> posed_;
  std::vector<bool> all_finite_;
};

}  // namespace deformable_contact_monitor
