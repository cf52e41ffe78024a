// Where two bodies are in contact of which no pair of triangles is listed.
#pragma once

#include <visualization_msgs/Marker.h>

#include <vector>

#include "monitor/markers/marker_parts.h"

namespace deformable_contact_monitor {

// Appends, for each of the cycle's pairs of bodies that is in contact by a witness alone
// (PairDistance), a SPHERE_LIST "witness: <a>/<b>" of its two points, a's and b's in colors of
// their own.
void addWitnesses(const CycleReport& report, const MarkerOptions& options,
                  std::vector<visualization_msgs::Marker>* markers);

// The namespace begins with this.
extern const char* const kWitness;

}  // namespace deformable_contact_monitor
