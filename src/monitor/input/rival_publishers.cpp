// Notices when several nodes publish different meshes of one object, in turn.
#include "monitor/input/rival_publishers.h"

#include <cstring>
#include <iterator>

namespace deformable_contact_monitor {
namespace {

constexpr std::chrono::seconds kRemembered(5);

// Compares bytes, so that a vertex that is not a number equals itself. Where triangles are left out
// of a message, their id stands for them.
bool isSame(const DeformableMesh& a, const DeformableMesh& b) {
  return a.header.frame_id == b.header.frame_id && a.topology_id == b.topology_id &&
         (a.triangles.empty() || b.triangles.empty() || a.triangles == b.triangles) &&
         a.vertices.size() == b.vertices.size() &&
         (a.vertices.empty() || std::memcmp(a.vertices.data(), b.vertices.data(),
                                            sizeof(float) * a.vertices.size()) == 0);
}

}  // namespace

void RivalPublishers::look(const IncomingMesh& mesh) {
  if (mesh.publisher.empty() || mesh.is_deletion) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto old = last_.begin(); old != last_.end();) {
    old = mesh.arrival - old->second.arrival > kRemembered ? last_.erase(old) : std::next(old);
  }
  const auto before = last_.find(mesh.publisher);
  for (auto other = last_.begin(); other != last_.end(); ++other) {
    const auto& [name, theirs] = *other;
    if (before != last_.end() && before != other && theirs.arrival >= before->second.arrival &&
        !isSame(*theirs.message, *before->second.message) &&
        !isSame(*theirs.message, *mesh.message)) {
      const bool is_first = mesh.publisher < name;
      rivals_ = "two nodes publish different meshes of it in turn: " +
                (is_first ? mesh.publisher : name) + " and " + (is_first ? name : mesh.publisher) +
                "; stop one of them, or give them a topic and an object each";
      when_ = mesh.arrival;
    }
  }
  last_[mesh.publisher] = mesh;
}

void RivalPublishers::noteReusedId(const IncomingMesh& mesh) {
  const std::lock_guard<std::mutex> lock(mutex_);
  rivals_ = (mesh.publisher.empty() ? "its publisher" : mesh.publisher) +
            " changed the triangles and kept topology_id " +
            std::to_string(mesh.message->topology_id) +
            "; it must change both together, because meshes without triangles may be read with the "
            "wrong ones";
  when_ = mesh.arrival;
}

std::string RivalPublishers::describe(SteadyTime now) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return now - when_ <= kRemembered ? rivals_ : "";
}

}  // namespace deformable_contact_monitor
