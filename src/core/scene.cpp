#include "core/scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

// Unique in the process, so that a detector tells the bodies of different scenes apart.
std::uint64_t nextRevision() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

// Returns the length, or throws std::invalid_argument if it is negative or not finite.
float checkedLength(const Body& body, const std::string& what, float length_m) {
  if (std::isfinite(length_m) && length_m >= 0) return length_m;
  throw std::invalid_argument(body.name + ": " + what + " " + std::to_string(length_m) +
                              " m is not a finite number >= 0");
}

// Returns a pair of parts in ascending order.
PartPair orderedPair(BodyId a, PartId part_a, BodyId b, PartId part_b) {
  if (std::make_pair(b, part_b) < std::make_pair(a, part_a)) return {b, a, part_b, part_a};
  return {a, b, part_a, part_b};
}

bool hasPart(const Body& body, PartId part) {
  return std::binary_search(body.listed_parts.begin(), body.listed_parts.end(), part);
}

}  // namespace

void Scene::useMemory(std::pmr::memory_resource& memory) {
  memory_.resource = &memory;
  for (Body& body : bodies_) body.mesh.moveTo(memory);
}

BodyId Scene::addBody(std::string name, TriangleMesh mesh) {
  validate(mesh, name);
  Body body;
  body.name = std::move(name);
  body.mesh = std::move(mesh);
  body.mesh.moveTo(*memory_.resource);
  body.topology_revision = body.vertices_revision = nextRevision();
  bodies_.push_back(std::move(body));
  for (auto& row : enabled_) row.push_back(false);
  enabled_.emplace_back(bodies_.size(), false);
  pairs_revision_ = nextRevision();
  return static_cast<BodyId>(bodies_.size() - 1);
}

Body& Scene::checkedBody(BodyId id) {
  if (id >= bodies_.size()) {
    throw std::invalid_argument("body " + std::to_string(id) + " does not exist; there are " +
                                std::to_string(bodies_.size()));
  }
  return bodies_[id];
}

void Scene::setMesh(BodyId id, TriangleMesh mesh) {
  Body& body = checkedBody(id);
  validate(mesh, body.name);
  body.mesh.become(std::move(mesh));
  body.device_vertices.reset();
  body.earlier.reset();
  body.topology_revision = body.vertices_revision = nextRevision();
  if (!body.parts.empty()) setParts(id, {});
}

Body& Scene::checkedBody(BodyId id, std::size_t vertex_count, const float* vertices) {
  Body& body = checkedBody(id);
  if (vertex_count != body.mesh.vertexCount()) {
    throw std::invalid_argument(body.name + ": " + std::to_string(vertex_count) +
                                " vertices, but its triangles are of a mesh with " +
                                std::to_string(body.mesh.vertexCount()));
  }
  if (vertices == nullptr && vertex_count > 0) {
    throw std::invalid_argument(body.name + ": the pointer to its " + std::to_string(vertex_count) +
                                " vertices is null");
  }
  return body;
}

void Scene::setVertices(BodyId id, const float* xyz, std::size_t count) {
  Body& body = checkedBody(id, count, xyz);
  std::copy_n(xyz, 3 * count, body.mesh.vertices.begin());
  body.device_vertices.reset();
  body.vertices_revision = nextRevision();
}

void Scene::setDeviceVertices(BodyId id, const float* device_xyz, std::size_t count, void* stream) {
  Body& body = checkedBody(id, count, device_xyz);
  body.device_vertices.reset();
  if (count > 0) body.device_vertices = DeviceVertices{device_xyz, stream};
  body.vertices_revision = nextRevision();
}

void Scene::requireFinite(const Body& body, const RigidTransform& pose) {
  if (isFinite(pose)) return;
  throw std::invalid_argument(body.name + ": its pose has a non-finite number");
}

void Scene::setPose(BodyId id, const RigidTransform& pose) {
  Body& body = checkedBody(id);
  requireFinite(body, pose);
  body.pose = pose;
}

void Scene::setEarlier(BodyId id, const RigidTransform& pose, HostList<float> vertices) {
  Body& body =
      vertices.empty() ? checkedBody(id) : checkedBody(id, vertices.size() / 3, vertices.data());
  requireFinite(body, pose);
  if (vertices.size() % 3 != 0) {
    throw std::invalid_argument(body.name + ": " + std::to_string(vertices.size()) +
                                " earlier coordinates are not x y z each");
  }
  body.earlier = EarlierState{pose, std::move(vertices)};
  body.earlier_revision = nextRevision();
}

void Scene::clearEarlier(BodyId id) { checkedBody(id).earlier.reset(); }

void Scene::setPad(BodyId id, float pad_m) {
  Body& body = checkedBody(id);
  body.pad_m = checkedLength(body, "pad", pad_m);
}

void Scene::setMargin(BodyId id, float margin_m) {
  Body& body = checkedBody(id);
  body.own_margin_m = checkedLength(body, "margin", margin_m);
  sumUpMargins(&body);
}

void Scene::setRadius(BodyId id, float radius_m) {
  Body& body = checkedBody(id);
  body.radius_m = checkedLength(body, "radius", radius_m);
}

void Scene::setParts(BodyId id, std::vector<PartId> part_of_triangle) {
  Body& body = checkedBody(id);
  if (!part_of_triangle.empty() && part_of_triangle.size() != body.mesh.triangleCount()) {
    throw std::invalid_argument(
        body.name + ": parts are given for " + std::to_string(part_of_triangle.size()) +
        " triangles, but its mesh has " + std::to_string(body.mesh.triangleCount()));
  }
  bool has[256] = {};
  for (const PartId part : part_of_triangle) has[part] = true;
  if (part_of_triangle.empty()) has[0] = true;
  body.parts = std::move(part_of_triangle);
  body.listed_parts.clear();
  for (std::size_t part = 0; part < 256; ++part) {
    if (has[part]) body.listed_parts.push_back(static_cast<PartId>(part));
  }
  body.parts_revision = nextRevision();
  sumUpMargins(&body);
}

void Scene::setPartMargins(BodyId id, std::map<PartId, float> margins_m) {
  Body& body = checkedBody(id);
  for (const auto& [part, margin_m] : margins_m) {
    checkedLength(body, "the margin of part " + std::to_string(part) + ",", margin_m);
  }
  body.part_margins_m = std::move(margins_m);
  sumUpMargins(&body);
}

void Scene::sumUpMargins(Body* body) {
  body->margin_m = 0;
  for (const PartId part : body->listed_parts) {
    body->margin_m = std::max(body->margin_m, body->marginOf(part));
  }
}

void Scene::setPartPairEnabled(BodyId a, PartId part_a, BodyId b, PartId part_b, bool enabled) {
  checkedBody(a);
  checkedBody(b);
  const PartPair pair = orderedPair(a, part_a, b, part_b);
  const auto place = std::lower_bound(disabled_parts_.begin(), disabled_parts_.end(), pair);
  const bool is_disabled = place != disabled_parts_.end() && *place == pair;
  if (is_disabled == !enabled) return;
  pairs_revision_ = nextRevision();
  if (enabled) {
    disabled_parts_.erase(place);
  } else {
    disabled_parts_.insert(place, pair);
  }
}

void Scene::enableAllParts() {
  if (disabled_parts_.empty()) return;
  pairs_revision_ = nextRevision();
  disabled_parts_.clear();
}

bool Scene::partPairEnabled(BodyId a, PartId part_a, BodyId b, PartId part_b) const {
  return pairEnabled(a, b) && !std::binary_search(disabled_parts_.begin(), disabled_parts_.end(),
                                                  orderedPair(a, part_a, b, part_b));
}

bool Scene::partsMatter() const {
  return std::any_of(disabled_parts_.begin(), disabled_parts_.end(), [this](const PartPair& pair) {
    return enabled_[pair.body_a][pair.body_b] && hasPart(bodies_[pair.body_a], pair.part_a) &&
           hasPart(bodies_[pair.body_b], pair.part_b);
  });
}

void Scene::setPairEnabled(BodyId a, BodyId b, bool enabled) {
  checkedBody(a);
  checkedBody(b);
  if (enabled_[a][b] == enabled) return;
  pairs_revision_ = nextRevision();
  enabled_[a][b] = enabled;
  enabled_[b][a] = enabled;
}

bool Scene::pairEnabled(BodyId a, BodyId b) const { return enabled_.at(a).at(b); }

std::vector<std::pair<BodyId, BodyId>> Scene::enabledPairs() const {
  std::vector<std::pair<BodyId, BodyId>> pairs;
  for (BodyId a = 0; a < bodies_.size(); ++a) {
    for (BodyId b = a; b < bodies_.size(); ++b) {
      if (enabled_[a][b]) pairs.emplace_back(a, b);
    }
  }
  return pairs;
}

bool Scene::takesPart(BodyId id) const {
  const std::vector<bool>& row = enabled_.at(id);
  return std::find(row.begin(), row.end(), true) != row.end();
}

bool Scene::anyBody(float Body::*length_m) const {
  for (BodyId id = 0; id < bodies_.size(); ++id) {
    if (bodies_[id].*length_m > 0 && takesPart(id)) return true;
  }
  return false;
}

bool Scene::anyMargin() const { return anyBody(&Body::margin_m); }
bool Scene::anyPartMargin() const {
  for (BodyId id = 0; id < bodies_.size(); ++id) {
    const Body& body = bodies_[id];
    const bool differs =
        std::any_of(body.listed_parts.begin(), body.listed_parts.end(),
                    [&body](PartId part) { return body.marginOf(part) != body.margin_m; });
    if (differs && takesPart(id)) return true;
  }
  return false;
}

bool Scene::anyRadius() const { return anyBody(&Body::radius_m); }

bool Scene::anyPad() const { return anyBody(&Body::pad_m); }

std::size_t Scene::triangleCount() const {
  std::size_t count = 0;
  for (const Body& body : bodies_) count += body.mesh.triangleCount();
  return count;
}

}  // namespace deformable_contact_monitor
