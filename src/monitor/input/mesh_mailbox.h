// Where the meshes of one deformable object arrive, and where the newest waits.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "core/steady_time.h"
#include "monitor/input/mesh_adapters.h"

namespace deformable_contact_monitor {

struct ArrivedMesh {
  DeformableMesh::ConstPtr message;
  // The newest message with triangles that came since a mesh was last taken; null: none.
  DeformableMesh::ConstPtr keyframe;
  SteadyTime arrival;     // of `message`, at its receipt
  std::string refusal{};  // why it is no mesh, and only has a stamp; empty: it is one
};

struct ArrivalCounters {
  std::uint64_t received = 0;
  std::uint64_t dropped = 0;  // before their cycle: replaced by a newer one, or not wanted
  std::uint64_t stamped_on_receipt = 0;  // they had no stamp of their own
};

// Threads may call every function at any time.
//
// Triangles come with a message or stay as they were when their topology_id was last sent, so
// those of a message that was dropped are kept.
class MeshMailbox {
 public:
  // `object`: the name that its messages carry, or leave empty.
  explicit MeshMailbox(std::string object) : object_(std::move(object)) {}

  // Makes `message` the one that waits; `refusal` as in ArrivedMesh.
  void store(const DeformableMesh::ConstPtr& message, const std::string& refusal = "");
  void store(const ReceivedMesh& mesh);

  // Takes the mesh that waits, if one does: to look at it and to take it is one act, or a newer one
  // that arrives in between would be lost.
  std::optional<ArrivedMesh> take();

  // A newer one came before the cycle of a mesh that was taken.
  void noteReplaced();

  bool isEmpty() const;

  // Drops the mesh that waits if its stamp is `unwanted`, which must not call this mailbox.
  void dropIf(const std::function<bool(const ros::Time&)>& unwanted);

  ArrivalCounters counters() const;

 private:
  const std::string object_;

  mutable std::mutex mutex_;  // guards what follows
  ArrivedMesh waiting_;       // no message: none waits
  ArrivalCounters counters_;
};

using MeshMailboxes = std::deque<MeshMailbox>;  // in the order of the objects; they cannot be moved

// Whether a message of an object's topic speaks of that object.
bool isMeshOf(const std::string& object, const DeformableMesh& message);

}  // namespace deformable_contact_monitor
