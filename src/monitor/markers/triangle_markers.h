// Draws triangles: those in contact, those that passed, and the objects' surfaces.
#pragma once

#include <visualization_msgs/Marker.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "monitor/markers/decimated_surface.h"
#include "monitor/markers/marker_parts.h"

namespace deformable_contact_monitor {

// Keeps decimated surfaces from cycle to cycle. Not safe for use by several threads.
class TriangleMarkers {
 public:
  explicit TriangleMarkers(const MarkerOptions& options) : options_(options) {}

  // Appends one TRIANGLE_LIST per pair of bodies with contacts, one per pair that passed, and one
  // per object that triggered the cycle and has or had a mesh, as ContactMarkers::make() says. None
  // is empty.
  void add(const CycleReport& report, std::vector<visualization_msgs::Marker>* markers);

 private:
  // One surface at several resolutions, from fine to coarse.
  using Levels = std::vector<DecimatedSurface>;

  const HostList<std::uint32_t>& decimated(const CycleReport& report, BodyId object,
                                           std::size_t budget);

  const MarkerOptions options_;
  std::map<std::string, Levels> surfaces_;  // by object
  const HostList<std::uint32_t> nothing_;
};

}  // namespace deformable_contact_monitor
