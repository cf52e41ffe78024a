// Bodies that are alike in what they may touch: the sweeps run over pairs of such groups, so that
// no pair of bodies that is off is ever visited.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

struct DCM_EXPORT BodyGroups {
  std::vector<std::uint32_t> group;        // per body
  std::vector<std::vector<bool>> enabled;  // per pair of groups

  // Two bodies are in one group iff their rows of enabled pairs are equal; then every pair of
  // bodies of two groups, or of one, is enabled, or none is.
  explicit BodyGroups(const Scene& scene);
};

}  // namespace deformable_contact_monitor
