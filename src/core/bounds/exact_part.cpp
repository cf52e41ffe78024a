// Gives the exact detector a scene with its pairs alone, and merges its result with the contacts
// that were found by tiles. Both lists of contacts are sorted, and no pair of bodies has contacts
// in both, so one pass merges them.
#include "core/bounds/exact_part.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include "core/bounds/distance_rounding.h"
#include "core/common/contact_geometry.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

// Counts a contact, and makes it the pair's witness if it is the nearest so far. Separations are
// rounded to the nearest float32, so the next greater one is an upper bound.
void addContact(const DetectionResult& exact, std::size_t i, BodyDistance& distance) {
  ++distance.contact_count;
  const float separation_m = exact.separations_m.empty() ? 0 : exact.separations_m[i];
  const float high_m = separation_m > 0 ? std::nextafter(separation_m, INFINITY) : 0;
  if (high_m >= distance.high_m) return;
  distance.high_m = high_m;
  distance.witness = exact.contacts[i];
  if (exact.geometry.size() == exact.contacts.size()) {
    distance.point_a = exact.geometry[i].point_a;
    distance.point_b = high_m > 0 ? exact.geometry[i].point_b : exact.geometry[i].point_a;
  }
}

// Adds a distance for each pair of two different bodies. Its lower bound is 0 unless the exact
// detector listed all contacts. Then it follows from the nearest contact, or is the margin if there
// is no contact.
void addDistances(const Scene& scene, const std::vector<IdPair>& pairs,
                  const DetectionResult& exact, DetectionResult& result) {
  std::map<IdPair, BodyDistance> distances;
  const bool all_listed = exact.guaranteed && !exact.cut_off && exact.left_out == 0;
  for (const IdPair& pair : pairs) {
    if (pair.first == pair.second) continue;
    BodyDistance& distance = distances[pair];
    distance.body_a = pair.first;
    distance.body_b = pair.second;
    distance.is_listed = all_listed;
  }
  if (distances.empty()) return;
  for (std::size_t i = 0; i < exact.contacts.size(); ++i) {
    const auto found = distances.find({exact.contacts[i].body_a, exact.contacts[i].body_b});
    if (found != distances.end()) addContact(exact, i, found->second);
  }
  for (auto& [pair, distance] : distances) {
    if (all_listed && distance.contact_count == 0) {
      distance.low_m =
          pairMargin(scene.body(pair.first).margin_m, scene.body(pair.second).margin_m);
    } else if (all_listed) {
      // Separations are rounded to the nearest float32.
      distance.low_m = roundedDown(distance.high_m * (1 - 1e-6));
    }
    result.distances.push_back(distance);
  }
}

// Moves what belongs to two lists of contacts into one, in the order in which they were merged.
template <class List>
void mergeBeside(const std::vector<bool>& from_second, const List& second, List& first) {
  List merged;
  merged.reserve(from_second.size());
  std::size_t next[2] = {0, 0};
  for (const bool is_second : from_second) {
    merged.push_back(is_second ? second[next[1]++] : first[next[0]++]);
  }
  first = std::move(merged);
}

}  // namespace

const Scene& ExactPart::sceneOf(const Scene& scene, const std::vector<IdPair>& pairs) {
  // Bodies are the same if their names are. What else changed is known from revisions.
  const bool same_bodies = std::equal(
      scene.bodies().begin(), scene.bodies().end(), part_.bodies().begin(), part_.bodies().end(),
      [](const Body& a, const Body& b) { return a.name == b.name; });
  if (!same_bodies) {
    part_ = Scene();
    part_.useMemory(*memory_);
    copied_.assign(scene.bodyCount(), Copied());
    for (const Body& body : scene.bodies()) part_.addBody(body.name, TriangleMesh());
  }
  for (const auto& [a, b] : part_.enabledPairs()) {
    if (!std::binary_search(pairs.begin(), pairs.end(), std::make_pair(a, b))) {
      part_.setPairEnabled(a, b, false);
    }
  }
  for (const auto& [a, b] : pairs) part_.setPairEnabled(a, b, true);
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (part_.takesPart(id)) copy(scene.body(id), id);
  }
  return part_;
}

// Copies those parts of a body whose revision is new. Device vertices are passed on as they are.
void ExactPart::copy(const Body& body, BodyId id) {
  Copied& copied = copied_[id];
  if (copied.topology_revision != body.topology_revision) {
    part_.setMesh(id, body.mesh);
  } else if (copied.vertices_revision != body.vertices_revision && !body.device_vertices) {
    part_.setVertices(id, body.mesh.vertices.data(), body.mesh.vertexCount());
  }
  if (body.device_vertices && copied.vertices_revision != body.vertices_revision) {
    part_.setDeviceVertices(id, body.device_vertices->xyz, body.mesh.vertexCount(),
                            body.device_vertices->stream);
  }
  copied = {body.topology_revision, body.vertices_revision};
  part_.setPose(id, body.pose);
  part_.setMargin(id, body.margin_m);
}

void takeExactResult(const Scene& scene, const std::vector<IdPair>& pairs,
                     const DetectionResult& exact, DetectionResult& result) {
  result.contacts = exact.contacts;
  result.separations_m = exact.separations_m;
  result.geometry = exact.geometry;
  result.left_out = exact.left_out;
  if (exact.cut_off) result.cutOff(exact.cut_off_because);
  result.guaranteed = result.guaranteed && exact.guaranteed;
  result.started_cold = exact.started_cold;
  result.memory_bytes = exact.memory_bytes;
  result.counters = exact.counters;
  result.counters.triangles = scene.triangleCount();
  result.stages_ms.insert(result.stages_ms.end(), exact.stages_ms.begin(), exact.stages_ms.end());
  addDistances(scene, pairs, exact, result);
}

void mergeContacts(const Scene& scene, const Options& options,
                   const std::vector<ListedContact>& contacts, DetectionResult& result) {
  // The exact part may have no margin where the whole scene has one.
  if (scene.anyMargin()) result.separations_m.resize(result.contacts.size());
  if (contacts.empty()) return;
  // Geometry is all or nothing: if one of the lists lacks it, the merged result has none.
  const bool had_all_geometry = result.geometry.size() == result.contacts.size();
  DetectionResult added;
  added.contacts.reserve(contacts.size());
  for (const ListedContact& contact : contacts) {
    added.contacts.push_back(contact.pair);
    if (scene.anyMargin()) added.separations_m.push_back(contact.separation_m);
  }
  if (had_all_geometry) writeGeometry(scene, options, added);
  std::vector<bool> from_second;
  from_second.reserve(result.contacts.size() + contacts.size());
  std::size_t first = 0, second = 0;
  while (first < result.contacts.size() || second < contacts.size()) {
    const bool is_second =
        first == result.contacts.size() ||
        (second < contacts.size() && added.contacts[second] < result.contacts[first]);
    from_second.push_back(is_second);
    ++(is_second ? second : first);
  }
  mergeBeside(from_second, added.contacts, result.contacts);
  if (scene.anyMargin()) mergeBeside(from_second, added.separations_m, result.separations_m);
  if (options.geometry && had_all_geometry && added.geometry.size() == contacts.size()) {
    mergeBeside(from_second, added.geometry, result.geometry);
  } else {
    result.geometry.clear();
  }
}

}  // namespace deformable_contact_monitor
