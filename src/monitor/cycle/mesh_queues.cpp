// Which meshes of an object have a cycle: how long they wait for transforms, and which are dropped.
#include "monitor/cycle/mesh_queues.h"

namespace deformable_contact_monitor {

void MeshQueues::add(std::size_t object, CycleTurns::Waiting waiting, SteadyTime now) {
  const CycleTurns::Queue& queue = turns_.waiting(object);
  while (!queue.empty() && !inputs_[object].has(queue.front().stamp)) dropFirst(object);
  const bool is_again = !queue.empty() && queue.back().stamp == waiting.stamp;
  if (is_again) return meshes_[object].noteReplaced();  // that cycle has the newer of the two
  const bool may_replace = turns_.isLastReplaceable(object);
  waiting.held_up = may_replace && mustWait(object, waiting.stamp);
  if (!may_replace || waiting.held_up) return turns_.wait(object, waiting, now);
  meshes_[object].noteReplaced();
  turns_.replaceLast(object, waiting);
}

bool MeshQueues::isReady(std::size_t object, SteadyTime now) {
  const CycleTurns::Queue& queue = turns_.waiting(object);
  while (queue.size() > 1 && now >= queue[0].give_up && !mustWait(object, queue[1].stamp)) {
    dropFirst(object);
  }
  if (!mustWait(object, queue.front().stamp)) return true;
  turns_.holdUp(object);
  if (now < queue.front().give_up) return false;
  lookup_.giveUp(scene_.awaitedFrames(object, queue.front().stamp, inputs_));
  return true;
}

// Whether transforms that its cycle needs are late and may yet come.
bool MeshQueues::mustWait(std::size_t object, const ros::Time& stamp) const {
  return lookup_.isWorthWaiting(scene_.awaitedFrames(object, stamp, inputs_));
}

void MeshQueues::dropFirst(std::size_t object) {
  turns_.dropFirst(object);
  meshes_[object].noteReplaced();
}

}  // namespace deformable_contact_monitor
