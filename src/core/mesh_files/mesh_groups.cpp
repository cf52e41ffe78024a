#include "core/mesh_files/mesh_groups.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include "core/mesh_files/mesh_text.h"

namespace deformable_contact_monitor {

void MeshGroups::Group::add(std::size_t first, std::size_t end) {
  if (first == end) return;
  const auto begin = static_cast<std::uint32_t>(first), last = static_cast<std::uint32_t>(end - 1);
  if (!triangles.empty() && begin <= std::uint64_t{triangles.back().second} + 1) {
    triangles.back().second = std::max(triangles.back().second, last);
  } else {
    triangles.emplace_back(begin, last);
  }
}

MeshGroups::MeshGroups(const std::vector<std::string>& names) {
  for (const std::string& name : names) wanted_[name];
}

MeshGroups::Group* MeshGroups::find(std::string_view name) {
  const auto found = wanted_.find(name);
  if (found == wanted_.end()) return nullptr;
  found->second.exists = true;
  return &found->second;
}

void MeshGroups::note(std::string_view name) {
  constexpr std::size_t kMost = 10;
  if (noted_.size() > kMost) return;
  const std::string text = noted_.size() == kMost ? "others" : quoted(name);
  if (std::find(noted_.begin(), noted_.end(), quoted(name)) == noted_.end()) noted_.push_back(text);
}

void MeshGroups::requireAll(const std::string& path) const {
  for (const auto& [name, group] : wanted_) {
    if (!group.exists) {
      std::string all;
      for (const std::string& noted : noted_) all += (all.empty() ? "" : ", ") + noted;
      throw std::runtime_error(path + ": has no group " + quoted(name) + "; it has " +
                               (all.empty() ? "none" : all));
    }
    if (group.triangles.empty()) {
      throw std::runtime_error(path + ": group " + quoted(name) + " has no triangle");
    }
  }
}

}  // namespace deformable_contact_monitor
