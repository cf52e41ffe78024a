// The detection thread's work: meshes and requests in, cycles out.
#pragma once

#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/containment.h"
#include "core/detector.h"
#include "core/steady_time.h"
#include "monitor/cycle/cycle_budget.h"
#include "monitor/cycle/cycle_clock.h"
#include "monitor/cycle/cycle_sink.h"
#include "monitor/cycle/cycle_turns.h"
#include "monitor/cycle/mailbox.h"
#include "monitor/cycle/mesh_queues.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle/step_planner.h"
#include "monitor/cycle/step_runner.h"
#include "monitor/input/mesh_input.h"
#include "monitor/input/mesh_mailbox.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/live_parameters.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// What other threads hand to the loop. All of it guards itself and must outlive the loop.
struct LoopSources {
  Mailbox& requests;
  MeshMailboxes& meshes;
  tf2::BufferCore& transforms;
  // Null while there is no robot; another object means another robot.
  std::function<std::shared_ptr<const RobotGeometry>()> newest_robot;
};

struct LoopTime {
  std::function<SteadyTime()> steady;
  std::function<ros::Time()> ros;  // zero: no clock yet
};

// Owns all that the detection thread alone may touch. One thread at a time; no lock is held while
// it detects.
class DetectionLoop {
 public:
  // The parameters must outlive this.
  DetectionLoop(const MonitorParameters& parameters, LoopSources sources, LoopTime time,
                std::unique_ptr<Detector> detector, std::unique_ptr<CycleSink> sink);
  DetectionLoop(const DetectionLoop&) = delete;
  DetectionLoop& operator=(const DetectionLoop&) = delete;

  // Looks at everything once and makes at most one cycle, so that requests and the clock are looked
  // at in between. Returns when to call it again unless something happens before. A
  // std::exception (out of memory, say) is reported, not thrown: the next mesh may be smaller.
  SteadyTime step();

 private:
  void lookAtTime();
  void lookAtRequests();
  void lookAtRobot();
  void noteRules();
  void applyLive(const LiveParameters& live);
  void applyEnabled(bool enabled);
  void warnOfUnknownNames();
  void reset(const std::string& reason);
  void dropLeftovers();

  void takeMeshes();
  ros::Time cycleStamp(const ros::Time& stamp, bool refused) const;
  void lookAtRobotsTime();
  std::optional<ros::Time> robotsStamp() const;
  void takeTurn(const std::vector<std::size_t>& who);
  double mostS(const std::vector<std::size_t>& who) const;
  bool detect(const ros::Time& t, const CycleTrigger& trigger, double most_s, double waited_s,
              SteadyTime mesh_arrival);
  const DetectionResult& runDetector(const Limits& limits);

  void listPairs();
  void heartbeat();
  std::vector<std::string> whyUnknown() const;
  CycleReport makeReport(const ros::Time& stamp);
  void lookAtMisses(const TransformReport& transforms);
  SteadyTime wakeTime() const;

  const MonitorParameters& parameters_;
  const LoopSources sources_;
  const LoopTime time_;
  LiveParameters live_;  // in place of the parameters'
  Options options_;      // with those
  const std::unique_ptr<Detector> detector_;
  const std::unique_ptr<CycleSink> sink_;
  CycleClock clock_;
  CycleBudget budget_;
  CycleTurns turns_;  // of the objects, in their order, and of the robot
  MeshInputs inputs_;
  MonitorScene scene_;
  TransformLookup lookup_;
  MeshQueues queues_;  // what an object waits for is its own affair
  ContainmentFinder containment_;
  StepPlanner planner_;
  StepRunner steps_;
  std::shared_ptr<const RobotGeometry> robot_;  // the one in scene_
  DetectionResult nothing_;                     // of a cycle without an enabled pair
  ros::Time robots_stamp_;                      // of its own last cycle
  SteadyTime robots_look_;                      // when to look for a new one
  bool enabled_ = true;
  bool names_checked_ = false;  // of the allowed contacts, against the bodies'
  bool had_many_ = false;       // contacts, in the last cycle
  std::uint64_t cycle_ = 0;
  SteadyTime list_due_, last_warning_;
};

}  // namespace deformable_contact_monitor
