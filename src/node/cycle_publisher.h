// Publishes what a cycle found.
#pragma once

#include <ros/node_handle.h>

#include <optional>
#include <string>

#include "monitor/cycle_report.h"
#include "monitor/markers/contact_markers.h"
#include "monitor/markers/patch_markers.h"
#include "monitor/rules/parameters.h"
#include "node/latest_contacts.h"
#include "node/patch_publisher.h"
#include "node/state_publisher.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// One thread at a time.
class CyclePublisher {
 public:
  // `states` and `latest` must outlive this.
  CyclePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node,
                 StatePublisher& states, LatestContacts& latest);

  struct Published {
    boost::shared_ptr<const ContactArray> contacts;
    SteadyTime states_out;  // the contacts may still have been on their way
  };

  // ~contact_states, ~contacts, ~contact_events, and ~swept_contacts for each step. Sets the
  // report's `now`. Leaves the contacts in the latest ones.
  Published publish(CycleReport* report);

  // ~contact_states alone. Sets the report's `now`.
  void publishStates(CycleReport* report);

  // ~contact_patches if somebody listens.
  void publishPatches(const CycleReport& report) { patches_.publish(report); }
  bool wantsGeometry() const { return patches_.isAskedFor(); }
  void forgetPatches() { patches_.forget(); }

  // ~markers if somebody looks, not too often, with the patches of the same cycle.
  void publishMarkers(const CycleReport& report);
  void setMarkerRate(double rate_hz) { marker_rate_.emplace(rate_hz); }

  // As StatePublisher::forget.
  void forgetStates(const std::string& body, const std::string& reason) {
    states_.forget(body, reason);
  }

  // ~robot_meshes, latched.
  void publishRobot(const RobotGeometry& robot);

 private:
  StatePublisher& states_;
  LatestContacts& latest_;
  const std::size_t max_contacts_;
  const double marker_lifetime_s_;
  std::optional<MarkerRate> marker_rate_;  // always there
  ContactMarkers markers_;
  PatchPublisher patches_;
  PatchMarkers patch_markers_;
  ros::Publisher contacts_publisher_, markers_publisher_, robot_publisher_;
  ros::Publisher swept_publisher_;  // swept motion alone has one
};

}  // namespace deformable_contact_monitor
