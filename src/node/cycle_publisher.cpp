// Publishes what the detection loop reports. Contacts and states go out first and at the same time,
// because controllers wait for them. Patches follow, and markers, which are for people, come last.
#include "node/cycle_publisher.h"

#include <deformable_contact_monitor/ContactPatches.h>
#include <deformable_contact_monitor/SweptContacts.h>
#include <ros/console.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <chrono>
#include <cstdint>

#include "core/common/parallel.h"
#include "monitor/markers/contact_markers.h"
#include "monitor/messages/contact_messages.h"
#include "monitor/state/pair_state.h"

namespace deformable_contact_monitor {
namespace {

MarkerOptions markerOptions(const MonitorParameters& parameters) {
  MarkerOptions options;
  options.lifetime_s = parameters.marker_lifetime_s;
  options.max_triangles = parameters.max_marker_triangles;
  options.rules = stateRules(parameters);
  return options;
}

// Returns what ~contacts says of a cycle whose findings are discarded: nothing is known.
ContactArray discardedContacts(const CycleReport& report) {
  CycleReport nothing;
  nothing.header = report.header;
  nothing.cycle = report.cycle;
  nothing.now = report.now;
  nothing.options = report.options;
  nothing.backend = report.backend;
  nothing.bodies = report.bodies;
  for (BodyStatus& body : nothing.bodies) body.unknown_because = "discarded during the cycle";
  return toContactArray(nothing, 0);
}

}  // namespace

CyclePublisher::CyclePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node,
                               StatePublisher& states, NodeDiagnostics& diagnostics)
    : states_(states),
      diagnostics_(diagnostics),
      max_contacts_(parameters.max_contacts),
      marker_lifetime_s_(parameters.marker_lifetime_s),
      markers_(markerOptions(parameters)),
      patch_markers_(markerOptions(parameters)),
      marker_rate_(parameters.marker_rate_hz),
      contacts_publisher_(private_node.advertise<ContactArray>("contacts", 2)),
      patches_publisher_(private_node.advertise<ContactPatches>("contact_patches", 2)),
      markers_publisher_(private_node.advertise<visualization_msgs::MarkerArray>("markers", 1)),
      robot_publisher_(private_node.advertise<LinkMeshes>("robot_meshes", 1, true)) {
  if (parameters.motion == Motion::kInstant) return;
  constexpr std::uint32_t kIntervalsOfACycle = 16;
  swept_publisher_ = private_node.advertise<SweptContacts>("swept_contacts", kIntervalsOfACycle);
}

SteadyTime CyclePublisher::sendCycle(const CycleReport& report, SteadyTime start,
                                     SteadyTime mesh_arrival) {
  const Published published = publishContactsAndStates(report);
  CycleTimes times;
  times.states_s = toSeconds(published.states_out - mesh_arrival);
  if (!states_.isDiscarded(report.epoch)) publishPatches(report);
  times.latency_s = secondsSince(mesh_arrival);
  if (!states_.isDiscarded(report.epoch)) publishMarkers(report);
  checkBodies(report);
  times.work_s = secondsSince(start);
  diagnostics_.recordCycle(report, *published.contacts, times);
  diagnostics_.recordTrade(report, times.states_s);
  return published.states_out;
}

void CyclePublisher::sendHeartbeat(const CycleReport& report) {
  diagnostics_.recordCycle(report, *publishContactsAndStates(report).contacts, CycleTimes());
}

// Makes and publishes both messages at the same time, in two threads, because ~contacts may hold
// many pairs and must not delay ~contact_states. Both are out on return. What a cycle found is not
// published if a service has discarded it meanwhile.
CyclePublisher::Published CyclePublisher::publishContactsAndStates(const CycleReport& report) {
  Published out;
  parallelBoth(
      [&] {
        if (states_.isDiscarded(report.epoch)) {
          out.contacts = boost::make_shared<const ContactArray>(discardedContacts(report));
          return contacts_publisher_.publish(out.contacts);
        }
        out.contacts =
            boost::make_shared<const ContactArray>(toContactArray(report, max_contacts_));
        contacts_publisher_.publish(out.contacts);
        for (const SweepReport& sweep : report.sweeps) {
          swept_publisher_.publish(boost::make_shared<const SweptContacts>(
              toSweptContacts(report, sweep, max_contacts_)));
        }
      },
      [&] { out.states_out = states_.publish(report); });
  states_.setContacts(out.contacts, report.epoch);
  return out;
}

// Publishes the patches while somebody listens, also if there is none. Does not publish if no
// detection ran or if contacts have no geometry, because the subscriber came too late: an empty
// message would look like no contact.
void CyclePublisher::publishPatches(const CycleReport& report) {
  has_patches_ = false;
  if (!wantsGeometry() || report.result == nullptr) return;
  const DetectionResult& result = *report.result;
  if (result.geometry.size() != result.contacts.size()) return;
  patches_ = patch_finder_.find(*report.scene, result);
  // With a tolerance, the contacts of a pair may be listed only in part. Patches of these would
  // look as if they were all.
  const auto is_part = [&report](const Patch& patch) {
    const auto distance = boundsOf(report, {patch.body_a, patch.body_b, false}, 0);
    return distance && !distance->bounds->is_listed;
  };
  patches_.erase(std::remove_if(patches_.begin(), patches_.end(), is_part), patches_.end());
  patch_tracker_.assign(*report.scene, &patches_);
  has_patches_ = true;
  patches_publisher_.publish(
      boost::make_shared<const ContactPatches>(toContactPatches(report, patches_)));
}

// Publishes the markers if somebody listens, at most at the marker rate.
void CyclePublisher::publishMarkers(const CycleReport& report) {
  if (markers_publisher_.getNumSubscribers() == 0) return;
  if (!marker_rate_->isDue(report, std::chrono::steady_clock::now())) return;
  visualization_msgs::MarkerArray markers = markers_.make(report);
  patch_markers_.add(report, has_patches_ ? &patches_ : nullptr, &markers);
  addHeldMarkers(report, marker_lifetime_s_, &markers);
  markers_publisher_.publish(markers);
}

void CyclePublisher::showUnknown(const CycleReport& report) {
  if (markers_publisher_.getNumSubscribers() == 0) return;
  const visualization_msgs::MarkerArray markers = markers_.make(report);
  if (!markers.markers.empty()) markers_publisher_.publish(markers);
}

// Warns of bodies with an unlikely size or place, and of surfaces that are not closed.
void CyclePublisher::checkBodies(const CycleReport& report) {
  for (const auto& [object, anomaly] : size_check_.look(report, std::chrono::steady_clock::now())) {
    diagnostics_.recordAnomaly(object, anomaly);
  }
  if (report.containment == nullptr) return;
  for (const std::string& line : open_bodies_.look(report)) {
    ROS_WARN_STREAM(line << "; see config/README.md#detection");
  }
  diagnostics_.recordOpenBodies(open_bodies_.list());
}

void CyclePublisher::sendRobot(const RobotGeometry& robot) {
  robot_publisher_.publish(toLinkMeshes(robot, ros::Time::now()));
}

void CyclePublisher::recordReset(const std::string& reason) {
  patch_tracker_.forget();  // patches get new ids
  diagnostics_.recordReset(reason);
}

}  // namespace deformable_contact_monitor
