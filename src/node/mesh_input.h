// The meshes of one deformable object: which were accepted, and which is the newest at a time.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "node/mesh_mailbox.h"

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
  std::uint64_t dropped = 0;  // out of order
  std::uint64_t refused = 0;
  std::uint64_t topology_changes = 0;
  std::string refusal;  // of the latest mesh; empty: it was accepted
  ros::Time stamp;      // of the newest accepted mesh
};

// A refused mesh leaves the object without any: an older one must not pass for fresh. One thread at
// a time.
class MeshInput {
 public:
  // `object`: the name that messages carry, or leave empty.
  MeshInput(std::string object, double max_age_s);

  // Whether a mesh of this stamp is older than the newest accepted one by more than max_age_s.
  bool jumpsBack(const ros::Time& stamp) const;

  // Accepts the mesh or refuses it. Returns false if there is nothing new to look at: it is older
  // than the newest accepted one. A refused mesh (see counters().refusal) is something new. `now`
  // zero: no clock yet; else a mesh stamped more than a second ahead is refused.
  bool accept(const ArrivedMesh& mesh, const ros::Time& now);
  const MeshCounters& counters() const { return counters_; }

  // The newest accepted mesh with a stamp in [t - max_age_s, t], or null and why.
  const AcceptedMesh* newestAt(const ros::Time& t, std::string* why_not) const;

  // Forgets accepted meshes; triangles stay known, as topology ids are no matter of time.
  void forget();

 private:
  // These throw std::invalid_argument.
  void checkHeader(const DeformableMesh& message, const ros::Time& now) const;
  void learnTopology(const DeformableMesh& keyframe);
  void keep(const DeformableMesh::ConstPtr& message);

  const std::string object_;
  const std::int64_t max_age_ns_;

  MeshCounters counters_;
  std::deque<AcceptedMesh> accepted_;  // ascending stamps
  std::shared_ptr<const Topology> topology_;
  std::string topology_refusal_;  // why the newest triangles sent are not in topology_
};

}  // namespace deformable_contact_monitor
