// Publishes what a cycle found.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>
#include <deformable_contact_monitor/ContactStates.h>
#include <ros/node_handle.h>

#include <chrono>
#include <mutex>
#include <string>

#include "node/contact_markers.h"
#include "node/contact_state_tracker.h"
#include "node/cycle_report.h"
#include "node/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// latest() may be called by any thread, the rest by the detection thread alone.
class CyclePublisher {
 public:
  struct Latest {
    boost::shared_ptr<const ContactArray> contacts;  // null: nothing published yet
    boost::shared_ptr<const ContactStates> states;
  };

  CyclePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node);

  // ~contact_states, ~contacts and ~contact_events. Sets the report's age. Returns what went out.
  Latest publish(CycleReport* report);

  // ~markers if somebody looks, not too often.
  void publishMarkers(const CycleReport& report);

  // Ends every open contact with `reason`.
  void endContacts(const std::string& reason);

  // ~robot_meshes, latched.
  void publishRobot(const RobotGeometry& robot);

  Latest latest() const;

 private:
  void publishEvents();

  const std::size_t max_contacts_;
  const std::chrono::duration<double> marker_period_;
  ContactStateTracker tracker_;
  ContactMarkers markers_;
  std::chrono::steady_clock::time_point last_markers_;
  ros::Publisher states_publisher_, contacts_publisher_, events_publisher_, markers_publisher_,
      robot_publisher_;

  mutable std::mutex mutex_;
  Latest latest_;
};

}  // namespace deformable_contact_monitor
