// The triangles of a cycle's markers: those in contact, and the objects' surfaces.
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

// One thread at a time.
class TriangleMarkers {
 public:
  explicit TriangleMarkers(const MarkerOptions& options) : options_(options) {}

  // Appends a TRIANGLE_LIST for each pair of bodies with contacts, and one for each known object
  // whose cycle it is, as ContactMarkers::make() says; none of them empty.
  void add(const CycleReport& report, std::vector<visualization_msgs::Marker>* markers);

 private:
  // The same surface with ever fewer triangles, as far as contacts leave room for it.
  using Levels = std::vector<DecimatedSurface>;

  const HostList<std::uint32_t>& decimated(const CycleReport& report, BodyId object,
                                           std::size_t budget);

  const MarkerOptions options_;
  std::map<std::string, Levels> surfaces_;  // by object
  const HostList<std::uint32_t> nothing_;
};

}  // namespace deformable_contact_monitor
