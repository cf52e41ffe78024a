// The detection thread's work: it takes meshes and requests, and makes cycles.
#pragma once

#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/detector.h"
#include "core/steady_time.h"
#include "monitor/cycle/cycle_clock.h"
#include "monitor/cycle/cycle_detection.h"
#include "monitor/cycle/cycle_scheduler.h"
#include "monitor/cycle/cycle_sink.h"
#include "monitor/cycle/loop_requests.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle/step_planner.h"
#include "monitor/cycle/transform_warnings.h"
#include "monitor/input/mesh_input.h"
#include "monitor/input/transform_buffer.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// The objects that other threads share with the loop. Each is thread-safe and must outlive the
// loop.
struct LoopSources {
  LoopRequests& requests;
  MeshInputs& meshes;
  TransformBuffer& transforms;
  // Returns null while there is no robot, and another object when the robot has changed.
  std::function<std::shared_ptr<const RobotGeometry>()> newest_robot;
  // Returns who publishes transforms, as a text for people. May be empty.
  std::function<std::string()> transform_publishers{};
};

// The clocks that the loop uses; tests replace them.
struct LoopTime {
  std::function<SteadyTime()> steady;
  std::function<ros::Time()> ros;  // zero: no clock yet
  bool is_simulated = false;       // ROS time comes from /clock
};

// Owns everything that only the detection thread uses. It holds no lock while it detects. One
// thread at a time.
class DetectionLoop {
 public:
  // The parameters must outlive this.
  DetectionLoop(const MonitorParameters& parameters, LoopSources sources, LoopTime time,
                std::unique_ptr<Detector> detector, std::unique_ptr<CycleSink> sink);
  DetectionLoop(const DetectionLoop&) = delete;
  DetectionLoop& operator=(const DetectionLoop&) = delete;

  // Handles the clock, requests and new meshes, and then makes at most one cycle, so that requests
  // never wait for more than one cycle. Returns when to call it again unless something wakes the
  // thread before. A std::exception, for example out of memory, is reported and not thrown: the
  // next mesh may be smaller.
  SteadyTime step();

 private:
  void lookAtTime();
  bool mayLook() const { return enabled_ && clock_.isThere(); }
  void dropMeshes();
  void lookAtRequests();
  void lookAtRobot();
  void noteRules();
  void applyLive(const LiveParameters& live);
  void applyEnabled(const Requests& requests);
  void warnOfUnknownNames();
  void reset(const std::string& reason);
  void dropLeftovers();

  TransformGate transformGate();
  void takeMeshes();
  void lookAtDeletion(std::size_t object);
  ros::Time cycleStamp(const ros::Time& stamp, bool rejected) const;
  void lookAtRobotsTime();
  std::optional<ros::Time> nextRobotsStamp();
  void takeTurn(const std::vector<std::size_t>& who);
  double mostS(const std::vector<std::size_t>& who) const;
  TransformReport prepare(const ros::Time& t, const CycleTrigger& trigger);
  bool detect(const ros::Time& t, const CycleTrigger& trigger, double most_s, double waited_s,
              SteadyTime mesh_arrival);
  CycleReport findContacts(const ros::Time& t, const CycleTrigger& trigger, const Limits& limits);

  void listPairs();
  void showUnknown();
  void heartbeat();
  std::vector<std::string> whyUnknown() const;
  CycleReport makeReport(const ros::Time& stamp);
  void lookAtTransforms(const TransformReport& transforms);
  SteadyTime wakeTime() const;

  const MonitorParameters& parameters_;
  const LoopSources sources_;
  const LoopTime time_;
  LiveParameters live_;  // replaces the values in parameters_
  Options options_;      // the detector's options with live_ applied
  const std::unique_ptr<Detector> detector_;
  const std::unique_ptr<CycleSink> sink_;
  CycleClock clock_;
  MeshInputs& inputs_;
  MonitorScene scene_;
  TransformLookup lookup_;
  CycleScheduler scheduler_;
  StepPlanner planner_;
  CycleDetection detection_;
  std::shared_ptr<const RobotGeometry> robot_;  // the one in scene_
  ros::Time robots_stamp_;                      // of its own last cycle
  SteadyTime robots_look_;                      // when to look for a new one
  bool enabled_ = true;
  std::vector<Wait> deletions_;  // by object, the last one that waited for a new mesh
  bool names_checked_ = false;   // of the allowed contacts, against the bodies'
  std::uint64_t cycle_ = 0, epoch_ = 0;
  std::uint64_t jumps_ = 0;  // TransformBuffer::lookAtClock()
  TransformWarnings transform_warnings_;
  SteadyTime list_due_, show_due_;
};

}  // namespace deformable_contact_monitor
