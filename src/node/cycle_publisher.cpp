// Publishes what a cycle found.
#include "node/cycle_publisher.h"

#include <boost/make_shared.hpp>

#include "core/parallel.h"
#include "node/contact_messages.h"
#include "node/time_difference.h"

namespace deformable_contact_monitor {
namespace {

MarkerOptions markerOptions(const MonitorParameters& parameters) {
  MarkerOptions options;
  options.lifetime_s = parameters.marker_lifetime_s;
  options.max_triangles = parameters.max_marker_triangles;
  return options;
}

}  // namespace

CyclePublisher::CyclePublisher(const MonitorParameters& parameters, ros::NodeHandle private_node,
                               LatestCycle& latest)
    : latest_(latest),
      max_contacts_(parameters.max_contacts),
      marker_period_(1 / parameters.marker_rate_hz),
      tracker_(parameters.debounce_on_cycles, parameters.debounce_off_cycles),
      markers_(markerOptions(parameters)),
      states_publisher_(private_node.advertise<ContactStates>("contact_states", 2)),
      contacts_publisher_(private_node.advertise<ContactArray>("contacts", 2)),
      events_publisher_(private_node.advertise<ContactEvent>("contact_events", 100)),
      markers_publisher_(private_node.advertise<visualization_msgs::MarkerArray>("markers", 1)),
      robot_publisher_(private_node.advertise<LinkMeshes>("robot_meshes", 1, true)) {}

PublishedCycle CyclePublisher::publish(CycleReport* report) {
  PublishedCycle cycle;
  report->age_s = secondsBetween(ros::Time::now(), report->header.stamp);
  parallelBoth(
      [&] {
        cycle.contacts =
            boost::make_shared<const ContactArray>(toContactArray(*report, max_contacts_));
        contacts_publisher_.publish(cycle.contacts);
      },
      [&] {
        cycle.states = boost::make_shared<const ContactStates>(tracker_.update(*report));
        states_publisher_.publish(cycle.states);
      });
  publishEvents();
  latest_.set(cycle);
  return cycle;
}

void CyclePublisher::endContacts(const std::string& reason) {
  tracker_.reset(reason);
  publishEvents();
}

void CyclePublisher::publishEvents() {
  for (const ContactEvent& event : tracker_.takeEvents()) events_publisher_.publish(event);
}

void CyclePublisher::publishMarkers(const CycleReport& report) {
  const auto now = std::chrono::steady_clock::now();
  if (markers_publisher_.getNumSubscribers() == 0 || now - last_markers_ < marker_period_) return;
  last_markers_ = now;
  markers_publisher_.publish(markers_.make(report));
}

void CyclePublisher::publishRobot(const RobotGeometry& robot) {
  robot_publisher_.publish(toLinkMeshes(robot, ros::Time::now()));
}

}  // namespace deformable_contact_monitor
