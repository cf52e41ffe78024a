// Publishes what a cycle found.
#include "node/cycle_publisher.h"

#include <boost/make_shared.hpp>
#include <chrono>

#include "core/common/parallel.h"
#include "monitor/markers/held_markers.h"
#include "monitor/messages/contact_messages.h"
#include "monitor/messages/swept_messages.h"

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
                               StatePublisher& states, LatestContacts& latest)
    : states_(states),
      latest_(latest),
      max_contacts_(parameters.max_contacts),
      marker_lifetime_s_(parameters.marker_lifetime_s),
      marker_rate_(parameters.marker_rate_hz),
      markers_(markerOptions(parameters)),
      patches_(private_node),
      patch_markers_(markerOptions(parameters)),
      contacts_publisher_(private_node.advertise<ContactArray>("contacts", 2)),
      markers_publisher_(private_node.advertise<visualization_msgs::MarkerArray>("markers", 1)),
      robot_publisher_(private_node.advertise<LinkMeshes>("robot_meshes", 1, true)) {
  if (parameters.motion == Motion::kInstant) return;
  constexpr std::uint32_t kStepsInACycle = 16;
  swept_publisher_ = private_node.advertise<SweptContacts>("swept_contacts", kStepsInACycle);
}

CyclePublisher::Published CyclePublisher::publish(CycleReport* report) {
  Published out;
  report->now = ros::Time::now();
  parallelBoth(
      [&] {
        out.contacts =
            boost::make_shared<const ContactArray>(toContactArray(*report, max_contacts_));
        contacts_publisher_.publish(out.contacts);
        for (const SweepReport& sweep : report->sweeps) {
          swept_publisher_.publish(boost::make_shared<const SweptContacts>(
              toSweptContacts(*report, sweep, max_contacts_)));
        }
      },
      [&] { out.states_out = states_.publish(*report); });
  latest_.set(out.contacts);
  return out;
}

void CyclePublisher::publishStates(CycleReport* report) {
  report->now = ros::Time::now();
  states_.publish(*report);
}

void CyclePublisher::publishMarkers(const CycleReport& report) {
  if (markers_publisher_.getNumSubscribers() == 0) return;
  if (!marker_rate_->isDue(report, std::chrono::steady_clock::now())) return;
  visualization_msgs::MarkerArray markers = markers_.make(report);
  patch_markers_.add(report, patches_.newest(), &markers);
  addHeldMarkers(report, marker_lifetime_s_, &markers);
  markers_publisher_.publish(markers);
}

void CyclePublisher::publishRobot(const RobotGeometry& robot) {
  robot_publisher_.publish(toLinkMeshes(robot, ros::Time::now()));
}

}  // namespace deformable_contact_monitor
