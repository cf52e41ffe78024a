// The report of one detection cycle. Everything that the monitor publishes, draws or counts comes
// from it.
//
// MonitorScene::makeReport() begins a report with the bodies and pairs of the cycle,
// StepPlanner::plan() adds the time intervals that end with the cycle, and CycleDetection::run()
// adds what was found. After that a report is only read.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>
#include <std_msgs/Header.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/analysis/containment.h"
#include "core/detector.h"
#include "core/options.h"
#include "core/scene.h"
#include "core/substeps.h"

namespace deformable_contact_monitor {

struct Topology;  // input/incoming_mesh.h

// A link, an object whose meshes come as messages, or an object that TF poses like a link.
enum class BodyKind : std::uint8_t { kLink = 0, kDeformable = 1, kRigid = 2 };

// A pair of bodies that the monitor reports. Pairs of classes that are switched off have no entry.
struct MonitoredPair {
  BodyId a = 0, b = 0;   // a <= b; a == b is self-contact
  bool allowed = false;  // the pair is reported as ALLOWED and is not computed
  // A named part of one of the bodies that the pair is about; 0: all of the body, but for parts
  // that are ALLOWED. At most one of the two is set; of self-contact, part_b.
  PartId part_a = 0, part_b = 0;
};

// The name of the part of an object that is held (~attach_object with a radius).
constexpr char kHeldPart[] = "held";

// The named parts of an object in the mesh that is in use, and the pieces that they consist of.
// Pieces are disjoint and number the parts of the scene's body. As long as nothing is held, piece i
// is part i, and piece 0 is what no part has. What is held is a part as well, "held", the last one.
// It may have triangles of other parts, which stay parts of these: so each of them, and piece 0, is
// split into a piece that is not held and one that is.
struct BodyParts {
  std::vector<std::string> names;      // of the parts 1, 2, ..., without the object's name
  std::vector<std::size_t> triangles;  // how many each piece has
  // Why nobody knows which triangles the parts other than "held" are; empty: it is known.
  std::string problem;
  // The part (0: none) from which each held piece was taken, ascending; empty: nothing is held.
  std::vector<PartId> held_of;
  // The margins of parts that have one of their own [m].
  std::map<PartId, float> margins_m;

  // Returns the part "held", which has the number of the first held piece; 0: nothing is held.
  PartId heldPart() const { return held_of.empty() ? 0 : static_cast<PartId>(names.size()); }
  std::size_t pieceCount() const { return firstHeld() + held_of.size(); }
  bool isHeld(PartId piece) const { return piece >= firstHeld(); }
  // Returns whether the piece belongs to a part other than 0.
  bool has(PartId part, PartId piece) const {
    return isHeld(piece) ? part == heldPart() || part == held_of[piece - firstHeld()]
                         : part == piece;
  }

 private:
  std::size_t firstHeld() const { return names.size() + (held_of.empty() ? 1 : 0); }
};

// The status of one body in a cycle.
struct BodyStatus {
  std::string name;
  BodyKind kind = BodyKind::kLink;
  ros::Time stamp;                           // of the data in use; zero if there is none
  std::uint32_t topology_id = 0;             // of the mesh in use; 0 without messages of it
  std::string unknown_because;               // why the body cannot be used; empty if it can
  bool triggered = false;                    // the cycle was started for this body
  std::uint64_t rejected = 0;                // triangles left out because a vertex is not finite
  std::shared_ptr<const BodyParts> parts{};  // null: the object has no named parts
  std::vector<std::uint64_t> rejected_by_part{};  // `rejected` by piece; empty: none
  bool without_mesh = false;  // an object whose mesh was asked for and is not there, or was refused

  std::size_t partCount() const { return parts == nullptr ? 0 : parts->names.size(); }
  std::size_t pieceCount() const { return parts == nullptr ? 1 : parts->pieceCount(); }
};

// Returns the pieces of a part; of part 0, those of the whole body. A piece that lost all of its
// triangles to a held one is left out, and so is piece 0 if the other parts have all triangles.
std::vector<PartId> piecesOf(const BodyStatus& body, PartId part);

// Returns the name of a body, or "object:part" for a named part of it.
std::string nameOf(const BodyStatus& body, PartId part);

// Returns whether this is the name of the body or of a part of it.
bool hasName(const BodyStatus& body, const std::string& name);

// The part of an object that is held, and the triangles in which it was chosen. It holds for
// meshes with the same triangles.
struct HeldPart {
  float radius_m = 0;                        // within which the triangles were of the holding links
  std::vector<std::uint32_t> triangles;      // ascending
  std::shared_ptr<const Topology> topology;  // of the mesh in which they were chosen
  ros::Time stamp;                           // of that mesh
};

// How a link carries a rigid object, which keeps its place in the link's frame.
struct RigidGrip {
  std::string link;
  RigidTransform link_from_object;
};

// How an object is held.
struct Attachment {
  std::vector<std::string> links;              // that may touch it, or rigid objects that may
  std::shared_ptr<const HeldPart> part = {};   // that they may touch; null: all of it
  std::shared_ptr<const RigidGrip> grip = {};  // of a rigid object; null: the object is none

  bool operator==(const Attachment& o) const {
    return links == o.links && part == o.part && grip == o.grip;
  }
};

// The objects that are held, by name.
using AttachedObjects = std::map<std::string, Attachment>;

// The motion of one body through a time interval that ends with a cycle.
struct StepBody {
  bool takes_part = false;        // some pair of the interval contains this body
  std::string skipped;            // why none of its pairs has an interval; empty if they have one
  RigidTransform pose;            // at the beginning of the interval
  DeformableMesh::ConstPtr mesh;  // with its vertices at the beginning; null if they are the same
  BodyPath path;                  // between the two poses; empty if vertices move on straight lines
  std::uint64_t rejected = 0;     // triangles with a vertex that is not finite at begin or end
  std::vector<std::uint64_t> rejected_by_part;  // `rejected` by piece; empty: none
};

// Continuous collision detection (motion: swept): one time interval that ends with the cycle. It
// begins at an earlier cycle of the bodies that triggered this one.
struct SweepReport {
  ros::Time from;                 // stamp of the earlier cycle; zero if there is no interval
  std::vector<BodyId> triggered;  // bodies whose interval this is, ascending; all links together
  // The enabled pairs of the cycle that belong to this interval. A pair belongs to at most one
  // interval. It has no verdict if one of its bodies is skipped.
  std::vector<MonitoredPair> pairs;
  std::vector<StepBody> bodies;              // indexed by BodyId
  std::shared_ptr<const StepResult> result;  // null without an interval and after a failure
  std::string problem;                       // why the detection failed; empty if it did not
  double compute_s = 0;
};

// The report of one cycle. It owns the lists of contacts, which stay valid as long as the report or
// a copy of it lives. The scene is the exception: it belongs to the monitor, and is that of the
// report only until the next cycle is prepared.
struct CycleReport {
  std_msgs::Header header;  // stamp of the mesh that triggered the cycle, and the reference frame
  std::uint64_t cycle = 0;  // number of the cycle, counted from 1
  std::uint64_t epoch = 0;  // in which the cycle began (LoopRequests::requestReset())
  // Indexed by BodyId: links in URDF order, then rigid objects, then the others.
  std::vector<BodyStatus> bodies;
  std::vector<MonitoredPair> pairs;       // of bodies
  std::vector<MonitoredPair> part_pairs;  // of a named part of one body with the other body
  // The pieces of bodies that rules leave out of pairs that are not `allowed`, in the order of
  // `pairs`; null: none. A new list is made whenever it may have changed, so pointers can be
  // compared.
  std::shared_ptr<const std::vector<PartPair>> allowed_parts;
  AttachedObjects attached;
  // The bodies as the detector saw them, and what it found at the stamp. Both are null if no
  // detection ran or if it failed; then every pair of the cycle is UNKNOWN.
  const Scene* scene = nullptr;
  std::shared_ptr<const DetectionResult> result;
  // The parts that lie within other bodies. It is null if they were not asked for, or if contacts
  // are missing.
  std::shared_ptr<const Containment> containment;
  Motion motion = Motion::kInstant;
  std::vector<SweepReport> sweeps;  // motion: swept; the time intervals that end with this cycle
  Options options;                  // of the detection, without the limits of this cycle
  std::string backend;              // that ran
  ros::Time now;                    // when the cycle was over, by the same clock as the stamp
};

// The pairs that have states, in the order of the states: those of bodies, and then those of parts.
inline std::size_t statePairCount(const CycleReport& report) {
  return report.pairs.size() + report.part_pairs.size();
}
inline const MonitoredPair& statePair(const CycleReport& report, std::size_t i) {
  const std::size_t bodies = report.pairs.size();
  return i < bodies ? report.pairs[i] : report.part_pairs[i - bodies];
}

// Returns whether a cycle decides about this pair: one of the pair's deformable objects triggered
// the cycle, or there is none and the robot's own cycle ran.
inline bool isOfCycle(const std::vector<BodyStatus>& bodies, const MonitoredPair& pair) {
  const BodyStatus &a = bodies.at(pair.a), &b = bodies.at(pair.b);
  const bool a_deforms = a.kind == BodyKind::kDeformable,
             b_deforms = b.kind == BodyKind::kDeformable;
  if (!a_deforms && !b_deforms) return a.triggered || b.triggered;
  return (a_deforms && a.triggered) || (b_deforms && b.triggered);
}

// Returns whether the parameters ask for contact geometry and the result has it for every contact.
bool hasGeometry(const CycleReport& report);

// Counts the rejected triangles of each body after a detection, and marks bodies as UNKNOWN whose
// pose makes vertices infinite. Needs the report's scene and result.
void noteRejected(CycleReport* report);

// Returns why the detection of a time interval failed; empty if none did.
std::string stepProblem(const CycleReport& report);

// Returns whether a deadline cut off the detection at the stamp or in an interval, or the search
// for parts within other bodies.
bool isOutOfTime(const CycleReport& report);

}  // namespace deformable_contact_monitor
