// The detection thread's work: meshes and requests in, cycles out.
#pragma once

#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/detector.h"
#include "node/cycle_clock.h"
#include "node/cycle_sink.h"
#include "node/mailbox.h"
#include "node/mesh_input.h"
#include "node/mesh_mailbox.h"
#include "node/monitor_scene.h"
#include "node/parameters.h"
#include "node/transform_lookup.h"

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
  std::function<CycleClock::SteadyTime()> steady;
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
  CycleClock::SteadyTime step();

 private:
  void lookAtTime();
  void lookAtRequests();
  void lookAtRobot();
  void applyEnabled(bool enabled);
  void warnOfUnknownNames();
  void reset(const std::string& reason);

  void dropLeftovers();
  // The earliest stamp that waits, if one does.
  std::optional<ros::Time> earliestWaiting() const;
  void takeAndDetect(const ros::Time& stamp);
  void detect(const ros::Time& t, CycleClock::SteadyTime mesh_arrival);
  void heartbeat();
  CycleReport makeReport(const ros::Time& stamp);
  void lookAtMisses(const TransformReport& transforms);

  const MonitorParameters& parameters_;
  const LoopSources sources_;
  const LoopTime time_;
  const std::unique_ptr<Detector> detector_;
  const std::unique_ptr<CycleSink> sink_;
  CycleClock clock_;
  MeshInputs inputs_;
  MonitorScene scene_;
  const TransformLookup lookup_;
  std::shared_ptr<const RobotGeometry> robot_;  // the one in scene_
  bool enabled_ = true;
  bool names_checked_ = false;  // of the allowed contacts, against the bodies'
  std::uint64_t cycle_ = 0;
  CycleClock::SteadyTime last_warning_;
};

}  // namespace deformable_contact_monitor
