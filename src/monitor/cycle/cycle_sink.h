// What the detection loop says to the outside.
#pragma once

#include <cstddef>
#include <string>

#include "core/steady_time.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle_report.h"
#include "monitor/input/mesh_input.h"
#include "monitor/rules/rules_in_force.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// The loop owns its sink and calls it from its own thread alone. No function may keep what it was
// given by reference.
class CycleSink {
 public:
  CycleSink() = default;
  CycleSink(const CycleSink&) = delete;
  CycleSink& operator=(const CycleSink&) = delete;
  virtual ~CycleSink() = default;

  // Whether the next cycle needs the geometry of its contacts.
  virtual bool wantsGeometry() const = 0;

  // A cycle begins, which may take long.
  virtual void recordStart() = 0;
  // A cycle: its work began at `start`, the mesh that asked for it came at `mesh_arrival`. The
  // report has no result if detection failed. Sets the report's `now`. Returns when the states were
  // out.
  virtual SteadyTime sendCycle(CycleReport* report, SteadyTime start, SteadyTime mesh_arrival) = 0;
  // A report without detection, so that silence is not mistaken for "no contact". Sets its `now`.
  virtual void sendHeartbeat(CycleReport* report) = 0;
  // The pairs that there are, or which of them are allowed, changed.
  virtual void listPairs(CycleReport* report) = 0;
  // What is known of the pairs of `body`, or of all if it is empty, is forgotten.
  virtual void forgetStates(const std::string& body, const std::string& reason) = 0;
  virtual void sendRobot(const RobotGeometry& robot) = 0;

  // The last mesh of this object was looked at: what is counted since the start.
  virtual void recordMesh(std::size_t object, const MeshCounters& counters) = 0;
  virtual void recordTransforms(const TransformReport& transforms) = 0;
  // What was looked for within the bodies of the report.
  virtual void recordContainment(const CycleReport& report) = 0;
  // Detection failed; empty: it did not.
  virtual void recordDetectorError(const std::string& error) = 0;
  // Margins and rules that hold from now on.
  virtual void recordRules(const RulesInForce& rules) = 0;
  virtual void setMarkerRate(double rate_hz) = 0;
  virtual void recordReset(const std::string& reason) = 0;
  virtual void recordEnabled(bool enabled) = 0;
};

}  // namespace deformable_contact_monitor
