// Patches of contacts as a message.
#include "monitor/messages/patch_messages.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "monitor/point32.h"

namespace deformable_contact_monitor {
ContactPatches toContactPatches(const CycleReport& report, const std::vector<Patch>& patches) {
  ContactPatches message;
  message.header = report.header;
  message.cycle = report.cycle;
  message.patches.reserve(patches.size());
  for (const Patch& patch : patches) {
    ContactPatch out;
    out.stamp = report.header.stamp;
    out.body_a = report.bodies.at(patch.body_a).name;
    out.body_b = report.bodies.at(patch.body_b).name;
    out.id = patch.id;
    out.pair_count = static_cast<std::uint32_t>(
        std::min<std::size_t>(patch.pair_count, std::numeric_limits<std::uint32_t>::max()));
    out.triangles_a = patch.triangles_a;
    out.triangles_b = patch.triangles_b;
    out.centroid = toPoint32(patch.centroid);
    out.normal = toPoint32(patch.normal);
    out.normal_spread = static_cast<float>(patch.normal_spread_rad);
    out.curve_length = static_cast<float>(patch.curve_length_m);
    out.area_a = static_cast<float>(patch.area_a_m2);
    out.area_b = static_cast<float>(patch.area_b_m2);
    out.min_separation = static_cast<float>(patch.min_separation_m);
    message.patches.push_back(std::move(out));
  }
  return message;
}

}  // namespace deformable_contact_monitor
