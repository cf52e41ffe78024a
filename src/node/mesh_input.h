// The meshes of one deformable object: what arrived, what waits, what was accepted.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Triangles that several meshes share. Two meshes have the same triangles iff they have the same
// object of this type.
struct Topology {
  std::uint32_t id = 0;
  std::size_t vertex_count = 0;
  std::vector<std::uint32_t> triangles;  // valid for vertex_count vertices
};

struct AcceptedMesh {
  DeformableMesh::ConstPtr message;  // its vertices fit the topology
  std::shared_ptr<const Topology> topology;

  const ros::Time& stamp() const { return message->header.stamp; }
};

struct MeshCounters {
  std::uint64_t received = 0;
  std::uint64_t dropped = 0;  // replaced by a newer one while waiting, or out of order
  std::uint64_t refused = 0;
  std::uint64_t topology_changes = 0;
  std::string refusal;  // of the latest mesh; empty: it was accepted
  ros::Time stamp;      // of the newest accepted mesh
};

// store() and counters() may be called by any thread, the rest by the detection thread alone.
//
// Triangles come with a message or stay as they were when their topology_id was last sent, so
// those of a message that was dropped are kept. A refused mesh leaves the object without any: an
// older one must not pass for fresh.
class MeshInput {
 public:
  // `object`: the name that messages carry, or leave empty.
  MeshInput(std::string object, double max_age_s);

  // Makes `message` the one that waits.
  void store(const DeformableMesh::ConstPtr& message);
  MeshCounters counters() const;

  // Stamp of the mesh that waits, if one does.
  std::optional<ros::Time> waitingStamp() const;
  // When it was stored; of use only while one waits.
  std::chrono::steady_clock::time_point waitingSince() const;
  // The mesh that waits is older than the newest accepted one by more than max_age_s.
  bool waitingJumpsBack() const;

  // Takes the mesh that waits. Returns false if there is nothing new to look at: none waits, or it
  // is older than the newest accepted one. A refused mesh (see counters().refusal) is something
  // new. `now` zero: no clock yet; else a mesh stamped more than a second ahead is refused.
  bool take(const ros::Time& now);

  // The newest accepted mesh with a stamp in [t - max_age_s, t], or null and why.
  const AcceptedMesh* newestAt(const ros::Time& t, std::string* why_not) const;

  // Drops the mesh that waits.
  void dropWaiting();
  // Forgets accepted meshes; triangles stay known, as topology ids are no matter of time.
  void forget();

 private:
  bool isOurs(const DeformableMesh& message) const;
  // The next three throw std::invalid_argument.
  void accept(const DeformableMesh::ConstPtr& message);
  void checkHeader(const DeformableMesh& message, const ros::Time& now) const;
  void learnTopology(const DeformableMesh& keyframe);

  const std::string object_;
  const std::int64_t max_age_ns_;

  mutable std::mutex mutex_;  // guards what follows, up to accepted_
  DeformableMesh::ConstPtr waiting_;
  std::chrono::steady_clock::time_point waiting_since_;
  DeformableMesh::ConstPtr keyframe_;  // newest message with triangles, not yet learned
  MeshCounters counters_;

  std::deque<AcceptedMesh> accepted_;  // ascending stamps
  std::shared_ptr<const Topology> topology_;
  std::string topology_refusal_;  // why the newest triangles sent are not in topology_
};

}  // namespace deformable_contact_monitor
