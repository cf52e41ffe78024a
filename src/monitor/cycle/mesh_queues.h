// Which meshes of an object have a cycle: how long they wait for transforms, and which are dropped.
#pragma once

#include <ros/time.h>

#include <cstddef>

#include "core/steady_time.h"
#include "monitor/cycle/cycle_turns.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/input/mesh_mailbox.h"
#include "monitor/input/transform_lookup.h"

namespace deformable_contact_monitor {

// The rules of the queues in CycleTurns. Stamps of a queue ascend, so its first mesh is the first
// to have its transforms. All that is referred to must outlive this. One thread at a time. Reads no
// clock.
class MeshQueues {
 public:
  MeshQueues(CycleTurns& turns, MeshMailboxes& meshes, const MeshInputs& inputs,
             const MonitorScene& scene, TransformLookup& lookup)
      : turns_(turns), meshes_(meshes), inputs_(inputs), scene_(scene), lookup_(lookup) {}

  // Of a mesh that was accepted or refused just now. A mesh that waits for transforms has its cycle
  // when they come, however many come after it. One that waits for its turn alone is replaced by
  // the next, unless that one has to wait for transforms. What the input has forgotten (of a jump
  // or a refusal, all that came before) has no cycle. Whatever is dropped is counted.
  void add(std::size_t object, CycleTurns::Waiting waiting, SteadyTime now);

  // Whether the first of the queue, which is not empty, has all transforms that may yet come, or
  // has waited for them until its give_up. One that had them but no turn until then makes way for
  // the next: the detector is too slow for all.
  bool isReady(std::size_t object, SteadyTime now);

 private:
  bool mustWait(std::size_t object, const ros::Time& stamp) const;
  void dropFirst(std::size_t object);

  CycleTurns& turns_;
  MeshMailboxes& meshes_;
  const MeshInputs& inputs_;
  const MonitorScene& scene_;
  TransformLookup& lookup_;
};

}  // namespace deformable_contact_monitor
