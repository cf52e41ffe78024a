// Some pairs of a scene as a scene of their own.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <utility>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// Bodies keep their ids, those without a pair are empty. Kept from cycle to cycle: what did not
// change is not copied, and pairs that stay the same keep their revision. For one moment: bodies
// have no earlier states.
class RestScene {
 public:
  // `memory`: where vertices lie.
  explicit RestScene(std::pmr::memory_resource& memory) : memory_(&memory) {}

  // With these pairs alone, (a, b) with a <= b. Good until the next call.
  const Scene& update(const Scene& scene, const std::vector<std::pair<BodyId, BodyId>>& pairs);

 private:
  struct Copied {
    std::uint64_t topology_revision = 0, vertices_revision = 0;  // 0: none
  };

  void copy(const Body& body, BodyId id);

  std::pmr::memory_resource* memory_;
  Scene rest_;
  std::vector<Copied> copied_;  // per body
};

}  // namespace deformable_contact_monitor
