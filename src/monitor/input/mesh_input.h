// The input of one deformable object: the only place that accepts, rejects, drops and counts its
// meshes. README.md shows the whole path of a mesh.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <boost/shared_ptr.hpp>
#include <boost/weak_ptr.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "monitor/input/incoming_mesh.h"
#include "monitor/input/rival_publishers.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// The meshes of an object since the start, by what became of them.
struct MeshCounters {
  std::uint64_t received = 0;
  // Meshes without a cycle of their own: a newer one came before they had one, they were out of
  // order, or the monitor was disabled or reset.
  std::uint64_t dropped = 0;
  std::uint64_t rejected = 0;            // see `problem`
  std::uint64_t stamped_on_receipt = 0;  // received without a stamp of their own
  std::uint64_t jumps = 0;               // how often the stamps went back
  std::uint64_t topology_changes = 0;
  std::string problem;  // why the latest mesh was rejected; empty: it was accepted
  ros::Time newest;     // stamp of the newest accepted mesh; zero: none yet
};

enum class Acceptance {
  kNothing,   // no mesh waits
  kAccepted,  // it is the object's newest mesh
  kJumped,    // accepted too, but its stamp is so much older that all earlier meshes were forgotten
  kDropped,   // it is out of order
  kRejected,  // it is invalid, and all earlier meshes were forgotten
};

// How long accepted meshes are kept, and how many.
struct MeshLimits {
  double max_age_s = 0.5;
  std::size_t history_bytes = std::size_t{512} << 20U;  // the newest four are always kept
};

// Holds the newest mesh that arrived until the detection thread takes it, and those that this
// thread accepted as long as a cycle may need them.
//
// Triangles come with a message, or stay as they were when their topology_id was last sent. So the
// newest triangles are kept even if their message is dropped before anyone takes it. They hold only
// for the connections that sent them: a publisher that starts anew may mean others by the same id.
//
// A rejected mesh leaves the object without any mesh: an older one must not pass for fresh.
class MeshInput {
 public:
  // `object` is the name that messages carry; messages may also leave it empty.
  MeshInput(std::string object, const MeshLimits& limits);

  // The following functions may be called by any thread.

  // Makes `mesh` the one that waits. One that waited before is dropped. A deletion waits beside it
  // for endGrace(), and is forgotten if a mesh comes before. A publisher of this process must not
  // change its last message and send it again; such a mesh is invalid, because the vertices of the
  // first one are gone.
  void store(IncomingMesh mesh);
  // Offers triangles as if a message with them had arrived and had been dropped; null: none.
  void storeTriangles(const DeformableMesh::ConstPtr& keyframe);
  bool hasWaiting() const;
  MeshCounters counters() const;
  // Returns the newest accepted mesh, which has a topology, or nothing and why.
  std::optional<IncomingMesh> newest(std::string* why_not) const;
  // Returns when the deletion arrived that waits; nothing: none does.
  std::optional<SteadyTime> deletedAt() const;
  // Returns which nodes publish different meshes of the object in turn, or which one changed the
  // triangles and kept their topology_id; empty: none.
  std::string rivals(SteadyTime now) const { return rivals_.describe(now); }

  // The following functions must be called by one thread, the detection thread.

  // Takes the mesh that waits and decides whether to accept it; *taken is set unless none waits.
  // Then it has a topology or a problem, or was dropped.
  //
  // A mesh that is older than the newest accepted one is dropped. If it is older by more than
  // max_age_s, the object's stamps have jumped back and it is accepted. `now` is the ROS time;
  // zero: there is no clock. With a clock, a mesh stamped more than a second ahead of it is
  // rejected. A mesh that is older than max_age_s by the clock is rejected too; but if a newer
  // accepted mesh is still fresh, the old one is only dropped.
  Acceptance take(const ros::Time& now, IncomingMesh* taken);

  // Makes the deletion that waits count, unless a mesh waits: the object has no mesh from then on.
  void endGrace();

  // Drops the mesh that waits if its stamp is `unwanted`, which must not call this object. Of such
  // a deletion, forgets the object's meshes.
  void dropIf(const std::function<bool(const ros::Time&)>& unwanted);
  // Counts a mesh that was taken and accepted, but is dropped before its cycle.
  void countDropped();

  // Returns the newest accepted mesh with a stamp in [t - max_age_s, t], or null and why. If some
  // of these are `preferred`, it is the newest of them. The pointer is valid until the next call of
  // take() or forget().
  const IncomingMesh* newestAt(
      const ros::Time& t, std::string* why_not,
      const std::function<bool(const IncomingMesh&)>& preferred = nullptr) const;
  // Returns whether an accepted mesh of exactly that stamp is kept.
  bool has(const ros::Time& stamp) const;

  // Forgets all accepted meshes. Triangles stay known: topology ids do not depend on time.
  void forget();

 private:
  using Connections = std::vector<boost::weak_ptr<const void>>;
  // A mesh with triangles, and the connections that sent them. No message: there is none.
  struct Keyframe {
    IncomingMesh mesh{};
    Connections senders{};
  };
  struct RejectedTopology {
    std::uint32_t id;
    std::string problem;
  };

  static bool contains(const Connections& connections,
                       const boost::shared_ptr<const void>& connection);
  static void add(const boost::shared_ptr<const void>& connection, Connections* connections);

  Acceptance decide(const Keyframe& keyframe, const ros::Time& now, IncomingMesh* mesh);
  bool isOld(const ros::Time& stamp, const ros::Time& now) const;
  bool isOutOfOrder(const ros::Time& stamp, const ros::Time& now) const;
  // The following four throw std::invalid_argument if the mesh is to be rejected.
  void checkHeader(const DeformableMesh& message) const;
  void checkAge(const ros::Time& stamp, const ros::Time& now) const;
  void learnTopology(const Keyframe& keyframe);
  void checkTopology(const IncomingMesh& mesh) const;
  bool keep(const IncomingMesh& mesh);

  const std::string object_;
  const std::int64_t max_age_ns_;
  const std::size_t history_bytes_;

  RivalPublishers rivals_;
  mutable std::mutex mutex_;  // guards the next seven members; never held for long
  std::optional<IncomingMesh> waiting_, deletion_;
  std::optional<IncomingMesh> newest_;  // the last of accepted_, for other threads
  Keyframe keyframe_;                   // newest triangles since the last take()
  MeshCounters counters_;
  DeformableMesh::ConstPtr last_;  // the message that came last, with its stamp at that time
  ros::Time last_stamp_;

  // Only the detection thread uses what follows.
  std::deque<IncomingMesh> accepted_;  // ascending stamps
  std::shared_ptr<const Topology> topology_;
  Connections senders_;                                // of the triangles of topology_
  std::optional<RejectedTopology> rejected_topology_;  // if the newest triangles are invalid
};

// One input for each object, in the order of the parameters. A deque, as an input cannot be moved.
using MeshInputs = std::deque<MeshInput>;

// Makes them, without any mesh.
MeshInputs makeMeshInputs(const MonitorParameters& parameters);

}  // namespace deformable_contact_monitor
