// Connects ROS to the monitor: meshes and transforms come in, contacts go out.
//
// README.md in this folder shows the threads. The detection loop has one of its own; callbacks
// reach it through members that both share, each of which guards itself.
#pragma once

#include <deformable_contact_monitor/AttachObject.h>
#include <deformable_contact_monitor/GetContacts.h>
#include <deformable_contact_monitor/SetAllowedContacts.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/steady_time.h"
#include "monitor/cycle/detection_loop.h"
#include "monitor/cycle/held_part.h"
#include "monitor/cycle/loop_requests.h"
#include "monitor/cycle/rigid_place.h"
#include "monitor/input/mesh_input.h"
#include "monitor/input/transform_buffer.h"
#include "monitor/rules/parameters.h"
#include "node/input_warnings.h"
#include "node/master_watch.h"
#include "node/node_diagnostics.h"
#include "node/reconfigure.h"
#include "node/robot_source.h"
#include "node/state_publisher.h"
#include "node/state_service.h"
#include "node/transform_input.h"

namespace deformable_contact_monitor {

// Owns everything from subscribers to publishers. Node and nodelet use the same class. The
// constructor starts all threads, the destructor ends them.
class ContactMonitor {
 public:
  // Reads the parameters of `private_node` and starts. Throws std::runtime_error, whose text lists
  // all problems, if they or the robot cannot be used.
  ContactMonitor(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ContactMonitor(const ContactMonitor&) = delete;
  ContactMonitor& operator=(const ContactMonitor&) = delete;
  ~ContactMonitor();

  // Returns whether the ROS master was restarted and no longer knows this node. Nobody finds the
  // node then, and only a new process can register again. Any thread.
  bool isUnregistered() const { return is_unregistered_; }

 private:
  // Parts of the constructor.
  std::unique_ptr<DetectionLoop> makeLoop();
  // Returns the topic of an object, and the node handle in whose namespace it is.
  std::pair<ros::NodeHandle*, std::string> nameOf(const ObjectParameters& object);
  // Throws ParameterError if two objects have one topic.
  void subscribeToMeshes();
  void advertiseServices();

  // Services. Each returns false only if roscpp shall report a failure without an answer. All but
  // reloadRobot() and attachObject(), which have threads of their own, run in that of the
  // callbacks.
  bool setAllowedContacts(SetAllowedContacts::Request& request,
                          SetAllowedContacts::Response& response);
  bool attachObject(AttachObject::Request& request, AttachObject::Response& response);
  // They return the part of the object within the radius of the links, and how the first link
  // carries a rigid object. They throw std::invalid_argument with the reason if they cannot tell.
  std::shared_ptr<const HeldPart> findHeld(const AttachObject::Request& request,
                                           const RobotGeometry& robot);
  std::shared_ptr<const RigidGrip> findGrip(const AttachObject::Request& request,
                                            const RigidParameters& rigid);
  bool getContacts(GetContacts::Request& request, GetContacts::Response& response);
  bool setEnabled(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool requestReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool reloadRobot(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  // Called by the robot source after each new robot (in a callback thread), and by the detector
  // when its backend changes.
  void noteRobot();
  void noteBackend(const BackendState& state);

  // Runs in the states thread until the requests stop. Lets states become UNKNOWN when they are too
  // old.
  void keepStatesFresh();

  // Run in the watch thread, once a second.
  void checkInputsAndMaster();
  void lookAtInputs();
  void showStart(const std::vector<InputStatus>& inputs);
  std::vector<InputStatus> inputStatuses() const;
  void checkMaster();

  ros::NodeHandle node_, private_node_;
  const MonitorParameters parameters_;

  // Shared by the callbacks and the detection loop. The order matters: a member may refer to those
  // above it, and is destroyed before them.
  LoopRequests requests_;
  MeshInputs meshes_;
  TransformBuffer buffer_;
  TransformInput transforms_;  // fills the buffer, in a thread of its own
  StatePublisher states_;
  RobotSource robot_source_;
  NodeDiagnostics diagnostics_;

  // Receives the meshes of one object in a thread of its own. A large mesh takes long to read and
  // to convert, and those of other objects go on meanwhile.
  struct MeshReception {
    ~MeshReception() { queue.disable(); }  // wakes the thread, which would end only 0.1 s later
    ros::CallbackQueue queue;
    ros::Subscriber subscriber;
    ros::AsyncSpinner spinner{1, &queue};
  };

  // ~reload_robot and ~attach_object have queues of their own: a robot with bad files takes long to
  // read, and what a link holds of a large mesh to find. Messages must go on meanwhile.
  ros::CallbackQueue reload_queue_, attach_queue_;
  ros::AsyncSpinner reload_spinner_{1, &reload_queue_}, attach_spinner_{1, &attach_queue_};

  // The ROS master is asked in a thread of its own, because an answer may take long.
  ros::CallbackQueue watch_queue_;
  ros::AsyncSpinner watch_spinner_{1, &watch_queue_};
  InputWarnings input_warnings_{std::chrono::steady_clock::now()};
  MasterWatch master_watch_;
  SteadyTime master_due_;
  std::atomic<bool> is_unregistered_{false};
  std::string backend_, backend_problem_;     // at the start
  bool is_started_ = false;                   // the block of the start was shown
  std::unique_ptr<Reconfigure> reconfigure_;  // writes to the master

  std::unique_ptr<StateService> state_service_;  // answers planners, in threads of its own
  std::deque<MeshReception> receptions_;         // in the order of the objects
  std::vector<ros::ServiceServer> services_;
  ros::WallTimer diagnostics_timer_, watch_timer_;
  std::thread thread_;         // runs the detection loop
  std::thread states_thread_;  // publishes states that get too old, also during a detection
};

}  // namespace deformable_contact_monitor
