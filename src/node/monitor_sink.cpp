// What the detection loop says, on topics and in the diagnostics.
#include "node/monitor_sink.h"

#include <ros/console.h>

namespace deformable_contact_monitor {

void MonitorSink::recordStart() { diagnostics_.recordStart(); }

SteadyTime MonitorSink::sendCycle(CycleReport* report, SteadyTime start, SteadyTime mesh_arrival) {
  const CyclePublisher::Published sent = publisher_->publish(report);
  CycleTimes times;
  times.states_s = toSeconds(sent.states_out - mesh_arrival);
  publisher_->publishPatches(*report);
  times.latency_s = secondsSince(mesh_arrival);  // markers are for people and can wait
  publisher_->publishMarkers(*report);
  for (const auto& [object, oddity] : size_check_.look(*report, std::chrono::steady_clock::now())) {
    diagnostics_.recordOddity(object, oddity);
  }
  times.work_s = secondsSince(start);
  diagnostics_.recordCycle(*report, *sent.contacts, times);
  diagnostics_.recordTrade(*report, times.states_s);
  return sent.states_out;
}

void MonitorSink::recordContainment(const CycleReport& report) {
  for (const std::string& line : open_bodies_.look(report)) ROS_WARN_STREAM(line);
  diagnostics_.recordOpenBodies(open_bodies_.list());
}

void MonitorSink::sendHeartbeat(CycleReport* report) {
  diagnostics_.recordCycle(*report, *publisher_->publish(report).contacts, CycleTimes());
}

}  // namespace deformable_contact_monitor
