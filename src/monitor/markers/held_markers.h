// Objects that are held, as text in rviz.
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// Adds a text of namespace "held", "held: cloth by hand, finger", over each held object that
// triggered the cycle and has a finite vertex, in report.header's frame. It vanishes after
// `lifetime_s` (> 0) [s]. Nothing without a scene.
void addHeldMarkers(const CycleReport& report, double lifetime_s,
                    visualization_msgs::MarkerArray* markers);

}  // namespace deformable_contact_monitor
