// Publishes what the detection loop reports: contacts, states, patches and markers on their topics,
// and counts in the diagnostics.
#pragma once

#include <ros/node_handle.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/contact_patches.h"
#include "core/analysis/patch_tracker.h"
#include "core/steady_time.h"
#include "monitor/cycle/cycle_sink.h"
#include "monitor/cycle_report.h"
#include "monitor/diagnostics/body_checks.h"
#include "monitor/markers/contact_markers.h"
#include "monitor/rules/parameters.h"
#include "node/node_diagnostics.h"
#include "node/state_publisher.h"

namespace deformable_contact_monitor {

// The node's CycleSink. The detection thread alone calls it.
class CyclePublisher : public CycleSink {
 public:
  // `states` and `diagnostics` must outlive this.
  CyclePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node,
                 StatePublisher& states, NodeDiagnostics& diagnostics);

  // The next cycle needs contact geometry while ~contact_patches has a subscriber.
  bool wantsGeometry() const override { return patches_publisher_.getNumSubscribers() > 0; }

  void recordStart() override { diagnostics_.recordStart(); }
  // Publishes ~contacts and ~swept_contacts beside ~contact_states and ~contact_events, then
  // ~contact_patches, then ~markers. `start` is when the cycle began, `mesh_arrival` when its mesh
  // came. Returns when the states were out.
  SteadyTime sendCycle(const CycleReport& report, SteadyTime start,
                       SteadyTime mesh_arrival) override;
  // Publishes contacts and states of a cycle in which nothing was detected, without patches and
  // markers.
  void sendHeartbeat(const CycleReport& report) override;
  // Publishes the states after the list of pairs, or which of them are allowed, has changed.
  void listPairs(const CycleReport& report) override { states_.publish(report); }
  // Publishes ~markers if somebody listens.
  void showUnknown(const CycleReport& report) override;
  void forgetStates(const std::string& body, const std::string& reason) override {
    states_.forget(body, reason);
  }
  // Publishes ~robot_meshes, latched.
  void sendRobot(const RobotGeometry& robot) override;

  void recordTransforms(const TransformReport& transforms) override {
    diagnostics_.recordTransforms(transforms);
  }
  void recordDetectorError(const std::string& error) override {
    diagnostics_.recordDetectorError(error);
  }
  void recordRules(const RulesInForce& rules) override { diagnostics_.recordRules(rules); }
  void setMarkerRate(double rate_hz) override { marker_rate_.emplace(rate_hz); }
  void recordReset(const std::string& reason) override;
  void recordEnabled(bool enabled) override { diagnostics_.recordEnabled(enabled); }

 private:
  struct Published {
    boost::shared_ptr<const ContactArray> contacts;
    SteadyTime states_out;
  };
  // Parts of sendCycle(), in the order in which it calls them. A topic without subscribers costs
  // nothing for patches and markers; contacts and states are always made.
  Published publishContactsAndStates(const CycleReport& report);
  void publishPatches(const CycleReport& report);
  void publishMarkers(const CycleReport& report);
  void checkBodies(const CycleReport& report);

  StatePublisher& states_;
  NodeDiagnostics& diagnostics_;
  // Copies of parameters: how many contacts a message lists at most (0: all), and how long RViz
  // shows a marker [s].
  const std::size_t max_contacts_;
  const double marker_lifetime_s_;

  ContactMarkers markers_;
  PatchMarkers patch_markers_;
  std::optional<MarkerRate> marker_rate_;  // never empty; emplace() changes the rate
  PatchFinder patch_finder_;
  PatchTracker patch_tracker_;
  std::vector<Patch> patches_;
  bool has_patches_ = false;  // patches_ are those of the last report
  SizeCheck size_check_;
  OpenBodies open_bodies_;

  ros::Publisher contacts_publisher_, patches_publisher_, markers_publisher_, robot_publisher_;
  ros::Publisher swept_publisher_;  // advertised only with motion: swept
};

}  // namespace deformable_contact_monitor
