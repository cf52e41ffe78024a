// Four vertices' fans at once: isFanCertified() in vector lanes.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/vertex_fans.h"
#include "core/cpu/lane_triangle.h"

namespace deformable_contact_monitor {

// The vertices of a mesh that have fans, in fours of fans alike: of as many ring points, all closed
// or none. The last four of a kind are filled up with its last vertex.
std::vector<std::uint32_t> foursAlike(const VertexFans& fans);

// Of four such vertices, by what isFanCertified() says of each, to the bit. `vertices`: all of the
// mesh, posed.
IntLanes areFansCertified(const VertexFans& fans, const std::uint32_t four[4],
                          const Vec3f* vertices);

}  // namespace deformable_contact_monitor
