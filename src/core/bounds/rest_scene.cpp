#include "core/bounds/rest_scene.h"

#include <algorithm>

namespace deformable_contact_monitor {

const Scene& RestScene::update(const Scene& scene,
                               const std::vector<std::pair<BodyId, BodyId>>& pairs) {
  const bool same_bodies = std::equal(
      scene.bodies().begin(), scene.bodies().end(), rest_.bodies().begin(), rest_.bodies().end(),
      [](const Body& a, const Body& b) { return a.name == b.name; });
  if (!same_bodies) {
    rest_ = Scene();
    rest_.useMemory(*memory_);
    copied_.assign(scene.bodyCount(), Copied());
    for (const Body& body : scene.bodies()) rest_.addBody(body.name, TriangleMesh());
  }
  for (const auto& [a, b] : rest_.enabledPairs()) {
    if (!std::binary_search(pairs.begin(), pairs.end(), std::make_pair(a, b))) {
      rest_.setPairEnabled(a, b, false);
    }
  }
  for (const auto& [a, b] : pairs) rest_.setPairEnabled(a, b, true);
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (rest_.takesPart(id)) copy(scene.body(id), id);
  }
  return rest_;
}

void RestScene::copy(const Body& body, BodyId id) {
  Copied& copied = copied_[id];
  if (copied.topology_revision != body.topology_revision) {
    rest_.setMesh(id, body.mesh);
  } else if (copied.vertices_revision != body.vertices_revision && !body.device_vertices) {
    rest_.setVertices(id, body.mesh.vertices.data(), body.mesh.vertexCount());
  }
  if (body.device_vertices && copied.vertices_revision != body.vertices_revision) {
    rest_.setDeviceVertices(id, body.device_vertices->xyz, body.mesh.vertexCount(),
                            body.device_vertices->stream);
  }
  copied = {body.topology_revision, body.vertices_revision};
  rest_.setPose(id, body.pose);
  rest_.setMargin(id, body.margin_m);
}

}  // namespace deformable_contact_monitor
