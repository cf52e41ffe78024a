// Matches meshes without triangles with later meshes that have them.
#include "tools/bags/triangles_ahead.h"

#include <algorithm>
#include <optional>

namespace deformable_contact_monitor {

// The order of stamps is known only after the last mesh, but most meshes are received in it. So
// only these triangles are kept: those that an earlier mesh lacked, and those with a later stamp
// than a mesh that was received after them.
void TrianglesAhead::add(const std::string& object, std::uint64_t number, const ros::Time& stamp,
                         const DeformableMesh::ConstPtr& mesh) {
  Object& of = objects_[object];
  const bool has_triangles = !mesh->triangles.empty();
  const bool falls = !of.meshes.empty() && stamp < of.meshes.back().stamp;
  of.meshes.push_back({stamp, number, mesh->topology_id, mesh->vertices.size(), has_triangles});
  // An earlier mesh may have waited for these triangles.
  if (has_triangles) {
    of.newest = mesh;
    of.newest_number = number;
    of.newest_stamp = stamp;
    of.is_newest_known = true;
    if (of.wanted.erase(mesh->topology_id) > 0) of.kept[number] = mesh;
    return;
  }
  if (falls) of.is_newest_known = false;
  const bool fits = of.newest && of.newest->topology_id == mesh->topology_id;
  if (fits && stamp < of.newest_stamp) of.kept[of.newest_number] = of.newest;
  if (!fits || !of.is_newest_known) of.wanted.insert(mesh->topology_id);
}

// Objects are independent of each other, and so are the parts of the recording.
void TrianglesAhead::settle(const std::vector<Cycle>& cycles) {
  std::vector<std::size_t> ranks(cycles.size());  // of the meshes, by number
  for (std::size_t i = 0; i < cycles.size(); ++i) ranks.at(cycles[i].number) = i;
  const auto rank = [&ranks](const Mesh& mesh) { return ranks.at(mesh.number); };
  for (auto& [name, object] : objects_) {
    std::sort(object.meshes.begin(), object.meshes.end(),
              [&rank](const Mesh& a, const Mesh& b) { return rank(a) < rank(b); });
    std::map<std::size_t, std::vector<Mesh>> parts;
    for (const Mesh& mesh : object.meshes) parts[cycles[rank(mesh)].part].push_back(mesh);
    for (const auto& [number, meshes] : parts) settle(meshes, object.kept);
  }
  objects_.clear();
}

// Goes backwards to find the next triangles of each mesh, then forwards to see which meshes need
// them.
void TrianglesAhead::settle(const std::vector<Mesh>& meshes, const Messages& with_triangles) {
  std::vector<DeformableMesh::ConstPtr> ahead(meshes.size());  // of each mesh
  DeformableMesh::ConstPtr next;
  for (std::size_t i = meshes.size(); i-- > 0;) {
    const Mesh& mesh = meshes[i];
    if (next &&
        (next->topology_id != mesh.topology_id || next->vertices.size() != mesh.coordinates))
      next = nullptr;
    const auto kept = with_triangles.find(mesh.number);
    if (kept != with_triangles.end()) next = kept->second;
    ahead[i] = next;
  }
  // Meshes with the same topology use the triangles that the node already knows.
  std::optional<std::uint32_t> known;  // the topology id whose triangles are known
  bool from_ahead = false;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const Mesh& mesh = meshes[i];
    if (mesh.has_triangles) {
      known = mesh.topology_id;
      from_ahead = false;
      continue;
    }
    if (known != mesh.topology_id) {
      if (!ahead[i]) continue;
      needed_[mesh.number] = ahead[i];
      known = mesh.topology_id;
      from_ahead = true;
    }
    count_ += from_ahead;
  }
}

DeformableMesh::ConstPtr TrianglesAhead::of(std::uint64_t number) const {
  const auto found = needed_.find(number);
  return found == needed_.end() ? nullptr : found->second;
}

}  // namespace deformable_contact_monitor
