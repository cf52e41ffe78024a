#include "core/common/body_groups.h"

#include <map>

namespace deformable_contact_monitor {

BodyGroups::BodyGroups(const Scene& scene) : group(scene.bodyCount()) {
  const auto count = static_cast<BodyId>(scene.bodyCount());
  std::map<std::vector<bool>, std::uint32_t> known;
  std::vector<BodyId> representative;
  for (BodyId a = 0; a < count; ++a) {
    std::vector<bool> row(count);
    for (BodyId b = 0; b < count; ++b) row[b] = scene.pairEnabled(a, b);
    const auto [place, added] =
        known.emplace(std::move(row), static_cast<std::uint32_t>(known.size()));
    group[a] = place->second;
    if (added) representative.push_back(a);
  }
  for (const BodyId a : representative) {
    std::vector<bool> row;
    row.reserve(representative.size());
    for (const BodyId b : representative) row.push_back(scene.pairEnabled(a, b));
    enabled.push_back(std::move(row));
  }
}

}  // namespace deformable_contact_monitor
