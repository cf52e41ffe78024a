// The monitor: meshes and transforms in, contacts out.
#pragma once

#include <deformable_contact_monitor/AttachObject.h>
#include <deformable_contact_monitor/GetContacts.h>
#include <deformable_contact_monitor/SetAllowedContacts.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2/buffer_core.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "core/steady_time.h"
#include "monitor/cycle/detection_loop.h"
#include "monitor/cycle/mailbox.h"
#include "monitor/input/mesh_mailbox.h"
#include "monitor/rules/parameters.h"
#include "node/input_warnings.h"
#include "node/latest_contacts.h"
#include "node/master_watch.h"
#include "node/node_diagnostics.h"
#include "node/reconfigure.h"
#include "node/robot_source.h"
#include "node/state_publisher.h"
#include "node/transform_input.h"

namespace deformable_contact_monitor {

// Connects topics, services and timers with the detection loop. The loop belongs to a thread of its
// own; callbacks reach it through what both share, and each such member guards itself. The same
// class serves node and nodelet.
class ContactMonitor {
 public:
  // Reads the parameters of `private_node` and starts. Throws std::runtime_error, saying all that
  // is wrong, if they or the robot cannot be used.
  ContactMonitor(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ContactMonitor(const ContactMonitor&) = delete;
  ContactMonitor& operator=(const ContactMonitor&) = delete;
  ~ContactMonitor();

  // The ROS master was started anew and does not know this node: nobody finds it, and only a new
  // process can register again. Any thread.
  bool isForgotten() const { return is_forgotten_; }

 private:
  void subscribeToMeshes();
  void advertiseServices();
  bool setAllowedContacts(SetAllowedContacts::Request& request,
                          SetAllowedContacts::Response& response);
  bool attachObject(AttachObject::Request& request, AttachObject::Response& response);
  bool getContacts(GetContacts::Request& request, GetContacts::Response& response);
  bool setEnabled(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool requestReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool reloadRobot(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  void noteRobot();
  std::unique_ptr<DetectionLoop> makeLoop();
  void noteBackend(const BackendState& state);
  void keepStatesFresh();
  void lookAround();
  void warnOfInputs();
  void lookAtMaster();

  ros::NodeHandle node_, private_node_;
  const MonitorParameters parameters_;

  // Shared by the callbacks and the loop.
  Mailbox mailbox_;
  MeshMailboxes mesh_mailboxes_;
  tf2::BufferCore buffer_;
  TransformInput transforms_;  // fills the buffer, in a thread of its own
  StatePublisher states_;
  LatestContacts latest_;
  RobotSource robot_source_;
  NodeDiagnostics diagnostics_;

  // Reading a robot takes long, if its files are bad; messages go on meanwhile.
  ros::CallbackQueue reload_queue_;
  ros::AsyncSpinner reload_spinner_{1, &reload_queue_};

  // The ROS master is asked in a thread of its own: it may take long.
  ros::CallbackQueue watch_queue_;
  ros::AsyncSpinner watch_spinner_{1, &watch_queue_};
  InputWarnings input_warnings_{std::chrono::steady_clock::now()};
  MasterWatch master_watch_;
  SteadyTime master_due_;
  std::atomic<bool> is_forgotten_{false};
  std::unique_ptr<Reconfigure> reconfigure_;  // it writes to the master

  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;
  ros::WallTimer diagnostics_timer_, watch_timer_;
  std::thread thread_;         // of the loop
  std::thread states_thread_;  // waits for no detection
};

}  // namespace deformable_contact_monitor
