// What the detection loop says, on topics and in the diagnostics.
#include "node/monitor_sink.h"

#include <ros/console.h>

namespace deformable_contact_monitor {

void MonitorSink::recordStart() { diagnostics_.recordStart(); }

SteadyTime MonitorSink::sendCycle(CycleReport* report, SteadyTime start, SteadyTime mesh_arrival) {
  const boost::shared_ptr<const ContactArray> sent = publisher_->publish(report);
  const SteadyTime published = std::chrono::steady_clock::now();
  publisher_->publishPatches(*report);
  const double latency_s = secondsSince(mesh_arrival);  // markers are for people and can wait
  publisher_->publishMarkers(*report);
  for (const auto& [object, oddity] : size_check_.look(*report, std::chrono::steady_clock::now())) {
    diagnostics_.recordOddity(object, oddity);
  }
  diagnostics_.recordCycle(*report, *sent, secondsSince(start), latency_s);
  diagnostics_.recordTrade(*report, toSeconds(published - mesh_arrival));
  return published;
}

void MonitorSink::recordContainment(const CycleReport& report) {
  for (const std::string& line : open_bodies_.look(report)) ROS_WARN_STREAM(line);
  diagnostics_.recordOpenBodies(open_bodies_.list());
}

void MonitorSink::sendHeartbeat(CycleReport* report) {
  const boost::shared_ptr<const ContactArray> sent = publisher_->publish(report);
  diagnostics_.recordCycle(*report, *sent, 0, 0);
}

}  // namespace deformable_contact_monitor
