// Contacts and deformable objects as rviz markers.
#include "monitor/markers/contact_markers.h"

#include <visualization_msgs/Marker.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "monitor/markers/line_markers.h"
#include "monitor/markers/witness_markers.h"

namespace deformable_contact_monitor {

using visualization_msgs::Marker;

visualization_msgs::MarkerArray ContactMarkers::make(const CycleReport& report) {
  visualization_msgs::MarkerArray array;
  const auto remove = [&](const MarkerKey& key, int action) {
    Marker marker;
    marker.header = report.header;
    marker.ns = key.first;
    marker.id = key.second;
    marker.action = action;
    marker.pose.orientation.w = 1;
    array.markers.push_back(std::move(marker));
  };
  if (!std::exchange(cleared_, true)) remove({"", 0}, Marker::DELETEALL);

  std::set<MarkerKey> gone = drawnOfCycle(report);
  std::vector<Marker> markers;
  triangles_.add(report, &markers);
  addLines(report, options_, &markers);
  addWitnesses(report, options_, &markers);
  for (const Marker& marker : markers) {
    gone.erase({marker.ns, marker.id});
    drawn_.insert({marker.ns, marker.id});
  }
  for (const MarkerKey& key : gone) {
    remove(key, Marker::DELETE);
    drawn_.erase(key);
  }
  array.markers.insert(array.markers.end(), std::make_move_iterator(markers.begin()),
                       std::make_move_iterator(markers.end()));
  return array;
}

// What earlier cycles drew of this one's bodies.
std::set<MarkerKey> ContactMarkers::drawnOfCycle(const CycleReport& report) const {
  std::set<MarkerKey> drawn;
  const auto note = [&](const MarkerKey& key) {
    if (drawn_.count(key) > 0) drawn.insert(key);
  };
  for (const MonitoredPair& pair : report.pairs) {
    if (!isOfCycle(report.bodies, pair)) continue;
    for (const char* const kind : {"", kSegments, kNormals, kPassed, kWitness}) {
      note(pairKey(report, pair.a, pair.b, kind));
    }
  }
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    if (report.bodies[id].triggered) note(surfaceKey(report, id));
  }
  return drawn;
}

bool MarkerRate::isDue(const CycleReport& report, SteadyTime now) {
  const auto hasNone = [&](const BodyStatus& body) {
    const auto last = last_.find(body.name);
    return body.triggered && (last == last_.end() || now - last->second >= period_);
  };
  if (std::none_of(report.bodies.begin(), report.bodies.end(), hasNone)) return false;
  for (const BodyStatus& body : report.bodies) {
    if (body.triggered) last_[body.name] = now;
  }
  return true;
}

}  // namespace deformable_contact_monitor
