// The monitor: meshes and transforms in, contacts out.
#pragma once

#include <deformable_contact_monitor/GetContacts.h>
#include <deformable_contact_monitor/SetAllowedContacts.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2/buffer_core.h>
#include <tf2_ros/transform_listener.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "node/cycle_publisher.h"
#include "node/detector_choice.h"
#include "node/mesh_input.h"
#include "node/monitor_scene.h"
#include "node/node_diagnostics.h"
#include "node/parameters.h"
#include "node/robot_source.h"
#include "node/transform_lookup.h"

namespace deformable_contact_monitor {

// Callbacks only store; one thread of its own detects and publishes, tf2 has another. No lock is
// held while it detects. The same class serves node and nodelet.
class ContactMonitor {
 public:
  // Reads the parameters of `private_node` and starts. Throws std::runtime_error, saying all that
  // is wrong, if they or the robot cannot be used.
  ContactMonitor(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ContactMonitor(const ContactMonitor&) = delete;
  ContactMonitor& operator=(const ContactMonitor&) = delete;
  ~ContactMonitor();

 private:
  using Clock = std::chrono::steady_clock;

  // Callbacks.
  void subscribeToMeshes();
  void advertiseServices();
  void wake();
  bool setAllowedContacts(SetAllowedContacts::Request& request,
                          SetAllowedContacts::Response& response);
  bool getContacts(GetContacts::Request& request, GetContacts::Response& response);
  bool setEnabled(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool requestReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool reloadRobot(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  // The detection thread (contact_monitor_thread.cpp).
  void run();
  void step();
  void checkClock();
  void applyRequests();
  void applyEnabled();
  void applyRobot();
  void reset(const std::string& reason);
  // The waiting mesh with the earliest stamp, or null.
  MeshInput* nextInput() const;
  bool isAhead(const ros::Time& stamp) const;  // of the clock
  void dropLeftovers();
  void cycleFor(MeshInput* input);
  void detectAndPublish(const ros::Time& t, Clock::time_point mesh_arrival);
  void heartbeat();
  CycleReport makeReport(const ros::Time& stamp);
  void warnOf(const TransformReport& transforms);
  void warnOfUnknownNames();

  struct Requests {
    bool reset = false;
    bool allowed_contacts = false;
  };

  std::mutex mutex_;  // guards requests_, allowed_ and woken_
  std::condition_variable wake_;
  Requests requests_;
  AllowedContacts allowed_;
  bool woken_ = false;
  std::atomic<bool> stop_{false};
  std::atomic<bool> enabled_{true};

  ros::NodeHandle node_, private_node_;
  const MonitorParameters parameters_;
  const MeshInputs inputs_;
  tf2::BufferCore buffer_;
  tf2_ros::TransformListener listener_;
  const TransformLookup lookup_;
  RobotSource robot_source_;
  CyclePublisher publisher_;
  NodeDiagnostics diagnostics_;

  // The detection thread alone.
  MonitorScene scene_;
  const std::unique_ptr<Detector> detector_;
  std::shared_ptr<const RobotGeometry> robot_;  // the one in scene_
  bool was_enabled_ = true;
  bool names_checked_ = false;  // of the allowed contacts, against the bodies'
  std::uint64_t cycle_ = 0;
  ros::Time last_now_;
  Clock::time_point earliest_cycle_, heartbeat_due_, wake_at_, settled_, last_warning_;

  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;
  ros::WallTimer diagnostics_timer_;
  std::thread thread_;
};

}  // namespace deformable_contact_monitor
