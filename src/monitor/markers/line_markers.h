// The lines of a cycle's markers: where triangles meet, and which way they part.
#pragma once

#include <visualization_msgs/Marker.h>

#include <vector>

#include "monitor/markers/marker_parts.h"

namespace deformable_contact_monitor {

// Appends, for each pair of bodies with contacts whose geometry the result has, LINE_LISTs, none of
// them empty:
//   "segments: <a>/<b>"  from point_a to point_b of each contact, paler where the triangles are
//   only
//                        near
//   "normals: <a>/<b>"   from the middle of that, `kNormalLengthM` along the normal and darker
//   there,
//                        where it is defined
// Of each, if there are more than max_triangles in the cycle, every k-th contact has one.
void addLines(const CycleReport& report, const MarkerOptions& options,
              std::vector<visualization_msgs::Marker>* markers);

constexpr float kNormalLengthM = 0.03F;

// Namespaces begin with these.
extern const char* const kSegments;
extern const char* const kNormals;

}  // namespace deformable_contact_monitor
