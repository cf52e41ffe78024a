#include "core/common/host_vertices.h"

#include <stdexcept>

namespace deformable_contact_monitor {

void requireHostVertices(const Scene& scene, const std::string& backend) {
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const Body& body = scene.body(id);
    if (!body.device_vertices || !scene.takesPart(id)) continue;
    throw std::invalid_argument(body.name + ": its vertices are on a device, which backend \"" +
                                backend + "\" cannot read");
  }
}

}  // namespace deformable_contact_monitor
