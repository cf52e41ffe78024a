// Publishes what a cycle found.
#pragma once

#include <ros/node_handle.h>

#include <chrono>
#include <string>

#include "node/contact_markers.h"
#include "node/contact_state_tracker.h"
#include "node/cycle_report.h"
#include "node/latest_cycle.h"
#include "node/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// One thread at a time.
class CyclePublisher {
 public:
  // `latest` must outlive this.
  CyclePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node,
                 LatestCycle& latest);

  // ~contact_states, ~contacts and ~contact_events. Sets the report's age. Returns what went out,
  // and leaves it in the latest cycle.
  PublishedCycle publish(CycleReport* report);

  // ~markers if somebody looks, not too often.
  void publishMarkers(const CycleReport& report);

  // Ends every open contact with `reason`.
  void endContacts(const std::string& reason);

  // ~robot_meshes, latched.
  void publishRobot(const RobotGeometry& robot);

 private:
  void publishEvents();

  LatestCycle& latest_;
  const std::size_t max_contacts_;
  const std::chrono::duration<double> marker_period_;
  ContactStateTracker tracker_;
  ContactMarkers markers_;
  std::chrono::steady_clock::time_point last_markers_;
  ros::Publisher states_publisher_, contacts_publisher_, events_publisher_, markers_publisher_,
      robot_publisher_;
};

}  // namespace deformable_contact_monitor
