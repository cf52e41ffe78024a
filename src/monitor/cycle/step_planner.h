// Plans the time intervals of continuous collision detection (motion: swept) that end with a cycle:
// from which earlier cycle each one starts, which pairs it covers, and how bodies moved in it.
// CycleDetection then looks for the contacts.
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle_report.h"
#include "monitor/input/mesh_input.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// The state of a body that a cycle used.
struct UsedBody {
  ros::Time stamp;      // of its data
  RigidTransform pose;  // of its frame
  IncomingMesh mesh;    // null for a link and a rigid object
  FramePlace place;     // of a link or a rigid object
};

// The states of all bodies that a cycle used.
struct UsedCycle {
  ros::Time stamp;
  std::uint64_t cycle = 0;                      // its number
  std::vector<std::optional<UsedBody>> bodies;  // by BodyId; empty for bodies that were not known
};

// Remembers what the previous cycle of each object, and of the robot, used. One thread at a time.
class StepPlanner {
 public:
  // The parameters must outlive this.
  explicit StepPlanner(const MonitorParameters& parameters);

  // Returns the intervals that end with a cycle, without results; none if the parameters ask for
  // instant motion. Call it after MonitorScene::prepare() with that trigger, with the report of the
  // same cycle. Bodies of the trigger that had the same previous cycle share an interval. Those
  // that have none to start from share one entry without `from`, in which `skipped` says why.
  // A body that rotates gets a path. Its frame is looked up every 5 ms between the two stamps, but
  // at most at 200 times.
  std::vector<SweepReport> plan(const CycleTrigger& trigger, const MonitorScene& scene,
                                const TransformLookup& lookup, const CycleReport& report);

  // Lets the next intervals of the trigger's bodies start at the cycle that was planned last. Call
  // it when the cycle's states are published: if they are lost, nobody knows what happened in its
  // intervals, so the next ones start where these started.
  void commit();

  // Forgets the previous cycle of an object (by index), or of all objects and the robot: their next
  // interval has nothing to start from, because of `why`.
  void forget(std::size_t object, const std::string& why);
  void forgetAll(const std::string& why);

 private:
  struct Previous {
    std::shared_ptr<const UsedCycle> used;  // null: `why` tells why there is none
    std::string why = "its first cycle";
  };

  // The earlier cycle that the interval of each trigger starts from, as previous_ is indexed; null
  // if there is none.
  using Beginnings = std::map<std::size_t, std::shared_ptr<const UsedCycle>>;

  std::shared_ptr<const UsedCycle> startOf(const MonitoredPair& pair, const MonitorScene& scene,
                                           const Beginnings& beginnings) const;
  std::string problemOf(std::size_t who, const UsedCycle& now, BodyId first_body) const;

  const MonitorParameters& parameters_;
  std::vector<Previous> previous_;  // by object, then the robot
  std::shared_ptr<const UsedCycle> planned_;
  std::vector<std::size_t> planned_triggers_;  // as previous_ is indexed
};

}  // namespace deformable_contact_monitor
