// Draws a cycle's contacts, patches and attached objects as rviz markers.
//
// All markers are in report.header's frame and vanish after their lifetime. rviz rejects a whole
// array if one of its markers is empty or has a point that is not finite, so such markers and
// points are left out everywhere. config/README.md lists all namespaces.
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/analysis/contact_patches.h"
#include "core/steady_time.h"
#include "monitor/cycle_report.h"
#include "monitor/markers/marker_parts.h"
#include "monitor/markers/triangle_markers.h"

namespace deformable_contact_monitor {

// Draws triangles, lines and witnesses. Not safe for use by several threads.
class ContactMarkers {
 public:
  explicit ContactMarkers(const MarkerOptions& options) : options_(options), triangles_(options) {}

  // Returns the markers of the cycle's pairs and of the objects that triggered it. Markers of other
  // bodies stay until their lifetime ends. The first array begins with a DELETEALL; later ones
  // delete what this cycle's bodies showed before and do not show any more. The kinds are:
  //   "<a>/<b>"            triangles in contact, or paler if they are listed within the margin
  //   "passed: <a>/<b>"    triangles that touched since the previous cycle and do not any more
  //   "<object>"           the rest of each object, translucent (rviz draws the robot); grey where
  //                        the object is UNKNOWN: its last mesh; named parts have their own colors
  //   "held: <object>"     the part of an object that is held, green
  //   "unknown"            a text over each object that is UNKNOWN, with the reason
  //   "segments: <a>/<b>"  a line from point_a to point_b of each contact, gray if only near
  //   "normals: <a>/<b>"   a line of kNormalLengthM from its middle along the normal; its tip is
  //                        dark
  //   "witness: <a>/<b>"   two spheres at the witness points of a contact without triangle pairs
  //   "nearest: <a>/<b>"   a line between the nearest points of a pair that is NEAR
  //   "distance: <a>/<b>"  a text at that line with its length [m]
  // Segments and normals need contacts with geometry. Over max_triangles, contacts come first, each
  // pair of bodies has an equal part, surfaces are decimated, and only every k-th contact has
  // lines.
  visualization_msgs::MarkerArray make(const CycleReport& report);

 private:
  // Returns the drawn markers of this cycle's pairs and objects: they change or are deleted.
  std::set<MarkerKey> drawnOfCycle(const CycleReport& report) const;

  const MarkerOptions options_;
  TriangleMarkers triangles_;
  bool cleared_ = false;
  std::set<MarkerKey> drawn_;
};

constexpr float kNormalLengthM = 0.03F;

// Draws contact patches. Not safe for use by several threads.
class PatchMarkers {
 public:
  explicit PatchMarkers(const MarkerOptions& options) : options_(options) {}

  // Adds the cycle's patches to an array of the same report; null means that none were computed.
  // Each patch has the namespace "patch: <a>/<b>": its triangles outlined in a color of its own, an
  // arrow along its normal, if it has one, and its id as text. Markers keep their ids while the
  // patch keeps its own. Deletes what the cycle's pairs showed before and do not show any more.
  // Over max_triangles, all patches may outline equally many triangles.
  void add(const CycleReport& report, const std::vector<Patch>* patches,
           visualization_msgs::MarkerArray* array);

 private:
  MarkerOptions options_;
  std::set<MarkerKey> drawn_;
};

// Adds a text "held: cloth by hand, finger" (namespace "held") over each attached object that
// triggered the cycle and has a finite vertex. It vanishes after `lifetime_s` (> 0) [s].
void addHeldMarkers(const CycleReport& report, double lifetime_s,
                    visualization_msgs::MarkerArray* markers);

// Limits how often markers are drawn. Each body has its own limit, so that objects which take turns
// are all drawn. Not safe for use by several threads. Reads no clock.
class MarkerRate {
 public:
  explicit MarkerRate(double rate_hz) : period_(fromSeconds(1 / rate_hz)) {}

  // Returns whether a body that triggered this cycle has not been drawn within the period. If so,
  // all bodies that triggered it count as drawn now.
  bool isDue(const CycleReport& report, SteadyTime now);

 private:
  const SteadyTime::duration period_;
  std::map<std::string, SteadyTime> last_;  // by body
};

}  // namespace deformable_contact_monitor
