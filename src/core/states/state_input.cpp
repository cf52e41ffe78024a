#include "core/states/state_input.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/common/posed_body.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

// Returns the rejected triangles of a body by part, ascending; the body's number is left 0.
std::vector<RejectedPart> countRejected(const Body& body) {
  std::uint64_t counts[256] = {};
  const PosedBody of(body);
  for (std::uint32_t t = 0; t < body.mesh.triangleCount(); ++t) {
    if (!isFinite(of.received(t))) ++counts[body.partOf(t)];
  }
  std::vector<RejectedPart> rejected;
  for (const PartId part : body.listed_parts) {
    if (counts[part] > 0) rejected.push_back({0, part, counts[part]});
  }
  return rejected;
}

}  // namespace

void requireValid(const Scene& scene, const StateBatch& batch) {
  if (batch.count > std::numeric_limits<std::uint32_t>::max()) {
    throw std::invalid_argument(std::to_string(batch.count) +
                                " states, but 32 bits have to number them");
  }
  if (batch.poses == nullptr && batch.count > 0 && !batch.moved.empty()) {
    throw std::invalid_argument("the poses of " + std::to_string(batch.count) +
                                " states are said to be at a null pointer");
  }
  std::vector<bool> is_moved(scene.bodyCount());
  for (const BodyId id : batch.moved) {
    if (id >= scene.bodyCount()) {
      throw std::invalid_argument("moved body " + std::to_string(id) +
                                  " does not exist; there are " +
                                  std::to_string(scene.bodyCount()));
    }
    if (is_moved[id]) {
      throw std::invalid_argument(scene.body(id).name + ": named twice among the moved bodies");
    }
    is_moved[id] = true;
  }
}

std::vector<IdPair> pairsOfStates(const Scene& scene, const StateBatch& batch) {
  std::vector<IdPair> pairs = scene.enabledPairs();
  const auto isMoved = [&batch](BodyId id) {
    return std::find(batch.moved.begin(), batch.moved.end(), id) != batch.moved.end();
  };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                             [&](const IdPair& pair) {
                               return pair.first == pair.second ||
                                      (!isMoved(pair.first) && !isMoved(pair.second));
                             }),
              pairs.end());
  return pairs;
}

bool partTakesPart(const Scene& scene, const std::vector<IdPair>& pairs, BodyId body, PartId part) {
  return std::any_of(pairs.begin(), pairs.end(), [&](const IdPair& pair) {
    if (pair.first != body && pair.second != body) return false;
    const BodyId other = pair.first == body ? pair.second : pair.first;
    const std::vector<PartId>& parts = scene.body(other).listed_parts;
    return std::any_of(parts.begin(), parts.end(), [&](PartId of_other) {
      return scene.partPairEnabled(body, part, other, of_other);
    });
  });
}

std::vector<RejectedPart> RejectedCounts::of(const Scene& scene, const std::vector<IdPair>& pairs) {
  std::vector<RejectedPart> rejected;
  of_body_.resize(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const bool takes_part = std::any_of(pairs.begin(), pairs.end(), [id](const IdPair& pair) {
      return pair.first == id || pair.second == id;
    });
    if (!takes_part) continue;
    const Body& body = scene.body(id);
    Counted& counted = of_body_[id];
    if (counted.vertices_revision != body.vertices_revision ||
        counted.parts_revision != body.parts_revision) {
      counted = {body.vertices_revision, body.parts_revision, countRejected(body)};
    }
    for (const RejectedPart& of : counted.parts) {
      if (partTakesPart(scene, pairs, id, of.part)) rejected.push_back({id, of.part, of.count});
    }
  }
  return rejected;
}

bool leavesFloats(const Body& body, const RigidTransform& pose) {
  if (pose.isIdentity()) return false;
  const PosedBody posed(body, pose);
  for (std::uint32_t t = 0; t < body.mesh.triangleCount(); ++t) {
    if (isFinite(posed.received(t)) && !isFinite(posed.triangle(t))) return true;
  }
  return false;
}

}  // namespace deformable_contact_monitor
