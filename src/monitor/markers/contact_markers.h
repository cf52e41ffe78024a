// Contacts and deformable objects as rviz markers.
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <set>
#include <string>

#include "core/steady_time.h"
#include "monitor/cycle_report.h"
#include "monitor/markers/marker_parts.h"
#include "monitor/markers/triangle_markers.h"

namespace deformable_contact_monitor {

// One thread at a time.
class ContactMarkers {
 public:
  explicit ContactMarkers(const MarkerOptions& options) : options_(options), triangles_(options) {}

  // Of the cycle's pairs and of the objects that triggered it, in report.header's frame; what was
  // drawn of others stays until its lifetime is over. The first array begins with a DELETEALL.
  //   "<a>/<b>"   the triangles in contact, or paler within the margin, of each pair of bodies that
  //               has any, links' and objects' in colors of their own
  //   "passed: <a>/<b>"  in swept motion: triangles that touched since the cycle before and are in
  //               no contact any more, in colors of their own
  //   "<object>"  the rest of each known object, translucent (rviz draws the robot)
  // one TRIANGLE_LIST each, with an id that is stable while the bodies are the same, none of them
  // empty: one that was drawn and has nothing to show any more is deleted. Over max_triangles,
  // contacts come first, then what is near, an equal share for each pair of bodies, and a surface
  // is decimated without holes. Non-finite triangles are left out: rviz refuses them. With the
  // contacts' geometry, lines as in line_markers.h, too; where bodies are in contact without a pair
  // of triangles, what witness_markers.h says.
  visualization_msgs::MarkerArray make(const CycleReport& report);

 private:
  std::set<MarkerKey> drawnOfCycle(const CycleReport& report) const;

  const MarkerOptions options_;
  TriangleMarkers triangles_;
  bool cleared_ = false;
  std::set<MarkerKey> drawn_;
};

// How often markers are drawn. Each body has a rate of its own: of objects in turns, none is left
// out. One thread at a time. Reads no clock.
class MarkerRate {
 public:
  explicit MarkerRate(double rate_hz) : period_(fromSeconds(1 / rate_hz)) {}

  // Whether this cycle's are due: a body that triggered it had none within the period. If so, all
  // that triggered it have theirs now.
  bool isDue(const CycleReport& report, SteadyTime now);

 private:
  const SteadyTime::duration period_;
  std::map<std::string, SteadyTime> last_;  // by body
};

}  // namespace deformable_contact_monitor
