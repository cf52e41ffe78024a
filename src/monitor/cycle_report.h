// What one detection cycle hands to everything that is published from it.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/analysis/containment.h"
#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/options.h"
#include "core/scene.h"
#include "core/substeps.h"

namespace deformable_contact_monitor {

enum class BodyKind : std::uint8_t { kLink = 0, kDeformable = 1 };

// How the monitor treats a pair of bodies. Pairs of classes that are off do not appear.
struct MonitoredPair {
  BodyId a = 0, b = 0;   // a <= b; a == b: self contact
  bool allowed = false;  // ALLOWED: not computed
};

struct BodyStatus {
  std::string name;
  BodyKind kind = BodyKind::kLink;
  ros::Time stamp;                // of the data used; zero: none
  std::uint32_t topology_id = 0;  // links: 0
  std::string unknown_because;    // empty: nothing is wrong with it
  bool triggered = false;         // this is its cycle
  std::uint64_t rejected = 0;     // triangles that took no part for a vertex that is not finite
};

// Objects that are held, each with the links that may touch it meanwhile.
using AttachedObjects = std::map<std::string, std::vector<std::string>>;

// How a body came from where it was at the beginning of a step to where it is in the cycle.
struct StepBody {
  bool takes_part = false;  // in some pair of the step
  std::string skipped;      // why none of its pairs has a step; empty: nothing is wrong with it
  RigidTransform pose;      // then
  DeformableMesh::ConstPtr mesh;  // whose vertices it had then; null: the present ones
  BodyPath path;                  // between the two poses; empty: its vertices move straight
  std::uint64_t rejected = 0;     // triangles with a vertex that is not finite, then or now
};

// Swept motion: the step from a previous cycle, of some that triggered this one.
struct SweepReport {
  ros::Time from;                 // of that cycle; zero: there is no step, see `bodies`
  std::vector<BodyId> triggered;  // whose step it is, ascending; of the robot's own: all links
  // Of the cycle's: those that were looked at in it and are this step's. Each pair is at most one
  // step's. Those with a body that is skipped have none.
  std::vector<MonitoredPair> pairs;
  std::vector<StepBody> bodies;        // by BodyId
  const StepResult* result = nullptr;  // null: there is no step, or the detection failed
  std::string problem;                 // why that failed
  double compute_s = 0;
};

struct CycleReport {
  std_msgs::Header header;  // stamp T of the triggering mesh, frame_id = reference_frame
  std::uint64_t cycle = 0;
  std::vector<BodyStatus> bodies;  // indexed by BodyId: links in URDF order, then objects
  std::vector<MonitoredPair> pairs;
  AttachedObjects attached;
  // Of this cycle's bodies, in the scene frame; null when no detection ran (every pair UNKNOWN).
  const Scene* scene = nullptr;
  const DetectionResult* result = nullptr;
  // Null where it was not looked for: it is not asked for, or contacts are missing.
  const Containment* containment = nullptr;
  // Swept: what the steps that end with this cycle found; `result` is of its stamp alone.
  Motion motion = Motion::kInstant;
  std::vector<SweepReport> sweeps;
  Options options;
  std::string backend;
  ros::Time now;  // when it was over, by the same clock
};

// Whether it is a cycle of that pair: one of its objects triggered it, or it is the robot's own and
// the pair is one of links.
inline bool isOfCycle(const std::vector<BodyStatus>& bodies, const MonitoredPair& pair) {
  const BodyStatus &a = bodies.at(pair.a), &b = bodies.at(pair.b);
  if (a.kind == BodyKind::kLink && b.kind == BodyKind::kLink) return a.triggered;
  return (a.kind == BodyKind::kDeformable && a.triggered) ||
         (b.kind == BodyKind::kDeformable && b.triggered);
}

// Whether the parameters ask for geometry, and the result has it of every contact.
bool hasGeometry(const CycleReport& report);

// After the detection: which bodies' triangles took no part, and which bodies are UNKNOWN for a
// pose that makes vertices infinite.
void noteRejected(CycleReport* report);

// After the detection, what is within what: not where contacts are missing, since who touches a
// surface is not known there. Where the result has distances, a part said to be within a body that
// is not apart from it by those may touch it as well.
void noteInside(const CycleLimit& limit, ContainmentFinder* finder, CycleReport* report);

// Why the detection of a step failed; empty: none did.
std::string stepProblem(const CycleReport& report);

// Whether a detection, of the stamp or of a step, or what was looked for after it, was cut off by
// its deadline.
bool isOutOfTime(const CycleReport& report);

}  // namespace deformable_contact_monitor
