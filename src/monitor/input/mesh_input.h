// The meshes of one deformable object: which were accepted, and which is the newest at a time.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "monitor/input/mesh_mailbox.h"

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
  std::uint64_t dropped = 0;  // out of order, or too old while there is a newer one
  std::uint64_t refused = 0;
  std::uint64_t jumps = 0;  // of the stamps, back
  std::uint64_t topology_changes = 0;
  std::string refusal;  // of the latest mesh; empty: it was accepted
  ros::Time stamp;      // of the newest accepted mesh
};

enum class Acceptance {
  kAccepted,
  kJumped,   // accepted; its stamp is so much older than the newest that those were forgotten
  kDropped,  // nothing new
  kRefused,  // see MeshCounters::refusal
};

struct MeshLimits {
  double max_age_s = 0.5;
  std::size_t history_bytes = std::size_t{512} << 20U;  // the newest mesh is always kept
};

// A refused mesh leaves the object without any: an older one must not pass for fresh. One thread at
// a time.
class MeshInput {
 public:
  // `object`: the name that messages carry, or leave empty.
  MeshInput(std::string object, const MeshLimits& limits);

  // A mesh older than the newest accepted one is dropped, but by more than max_age_s it is a jump
  // of the object's stamps. `now` zero: no clock; else a mesh stamped more than a second ahead is
  // refused, and so is one older than max_age_s, which is dropped instead while the newest accepted
  // one is not that old.
  Acceptance accept(const ArrivedMesh& mesh, const ros::Time& now);
  const MeshCounters& counters() const { return counters_; }

  // The newest accepted mesh with a stamp in [t - max_age_s, t], or null and why.
  const AcceptedMesh* newestAt(const ros::Time& t, std::string* why_not) const;

  // Whether an accepted mesh of that stamp is kept.
  bool has(const ros::Time& stamp) const;

  // Forgets accepted meshes; triangles stay known, as topology ids are no matter of time.
  void forget();

 private:
  struct RefusedTopology {
    std::uint32_t id;
    std::string why;
  };

  bool isOld(const ros::Time& stamp, const ros::Time& now) const;
  bool isOutdated(const ros::Time& stamp, const ros::Time& now) const;
  // These throw std::invalid_argument.
  void checkHeader(const DeformableMesh& message) const;
  void checkAge(const ros::Time& stamp, const ros::Time& now) const;
  void learnTopology(const DeformableMesh& keyframe);
  void checkTopology(const DeformableMesh& message) const;
  bool keep(const DeformableMesh::ConstPtr& message);

  const std::string object_;
  const std::int64_t max_age_ns_;
  const std::size_t history_bytes_;

  MeshCounters counters_;
  std::deque<AcceptedMesh> accepted_;  // ascending stamps
  std::shared_ptr<const Topology> topology_;
  std::optional<RefusedTopology> refused_topology_;  // of the newest triangles sent
};

}  // namespace deformable_contact_monitor
