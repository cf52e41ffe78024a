// The output of the detection loop, as an interface so that tests can run the loop without ROS
// topics. CyclePublisher (src/node) implements it.
#pragma once

#include <string>

#include "core/steady_time.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle_report.h"
#include "monitor/rules/rule_texts.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// The loop owns its sink and calls it from its own thread only. Arguments are valid during the
// call.
class CycleSink {
 public:
  CycleSink() = default;
  CycleSink(const CycleSink&) = delete;
  CycleSink& operator=(const CycleSink&) = delete;
  virtual ~CycleSink() = default;

  // Returns whether the next cycle needs the geometry of its contacts.
  virtual bool wantsGeometry() const = 0;

  // Tells that a cycle begins, which may take long.
  virtual void recordStart() = 0;
  // Publishes a cycle. Its work began at `start`; the mesh that triggered it came at
  // `mesh_arrival`. The report has no result if the detection failed. Returns when the states were
  // out.
  virtual SteadyTime sendCycle(const CycleReport& report, SteadyTime start,
                               SteadyTime mesh_arrival) = 0;
  // Publishes a report without a detection, so that silence is not mistaken for "no contact".
  virtual void sendHeartbeat(const CycleReport& report) = 0;
  // Publishes the states alone, because the list of pairs, or which of them are allowed, changed.
  virtual void listPairs(const CycleReport& report) = 0;
  // Shows people the objects that are UNKNOWN where they were last: those that triggered the
  // report.
  virtual void showUnknown(const CycleReport& report) = 0;
  // Forgets what is known of the pairs of `body`, or of all pairs if it is empty.
  virtual void forgetStates(const std::string& body, const std::string& reason) = 0;
  virtual void sendRobot(const RobotGeometry& robot) = 0;

  virtual void recordTransforms(const TransformReport& transforms) = 0;
  // Takes why the last detection failed; empty if it did not.
  virtual void recordDetectorError(const std::string& error) = 0;
  // Takes the margins and rules that hold from now on.
  virtual void recordRules(const RulesInForce& rules) = 0;
  virtual void setMarkerRate(double rate_hz) = 0;
  virtual void recordReset(const std::string& reason) = 0;
  virtual void recordEnabled(bool enabled) = 0;
};

}  // namespace deformable_contact_monitor
