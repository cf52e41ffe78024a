// Where the meshes of one deformable object arrive, and where the newest waits.
#include "monitor/input/mesh_mailbox.h"

#include <utility>

namespace deformable_contact_monitor {

bool isMeshOf(const std::string& object, const DeformableMesh& message) {
  return message.object.empty() || message.object == object;
}

void MeshMailbox::store(const DeformableMesh::ConstPtr& message, const std::string& refusal) {
  store(ReceivedMesh{message, refusal});
}

void MeshMailbox::store(const ReceivedMesh& mesh) {
  const DeformableMesh::ConstPtr& message = mesh.message;
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counters_.received;
  counters_.stamped_on_receipt += mesh.stamped_on_receipt;
  if (waiting_.message) ++counters_.dropped;
  waiting_.message = message;
  waiting_.refusal = mesh.refusal;
  waiting_.arrival = std::chrono::steady_clock::now() - fromSeconds(mesh.waited_s);
  if (!message->triangles.empty() && isMeshOf(object_, *message)) waiting_.keyframe = message;
}

std::optional<ArrivedMesh> MeshMailbox::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!waiting_.message) return std::nullopt;
  return std::exchange(waiting_, ArrivedMesh());
}

void MeshMailbox::noteReplaced() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counters_.dropped;
}

bool MeshMailbox::isEmpty() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !waiting_.message;
}

void MeshMailbox::dropIf(const std::function<bool(const ros::Time&)>& unwanted) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!waiting_.message || !unwanted(waiting_.message->header.stamp)) return;
  waiting_.message = nullptr;
  waiting_.refusal.clear();
  ++counters_.dropped;
}

ArrivalCounters MeshMailbox::counters() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counters_;
}

}  // namespace deformable_contact_monitor
