// Runs a cycle in five steps: it begins the search of the tiled pairs, runs the exact detector on
// the other pairs, goes on with the search, lists contacts, and merges the results. If there is a
// deadline, the first search gets half of the time, so that every pair has some bound, and the
// exact detector gets what is left then.
#include "core/bounds/bounded_cycle.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <numeric>

#include "core/bounds/exact_distances.h"
#include "core/common/contact_geometry.h"
#include "core/common/part_table.h"
#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

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

// Copies the exact detector's result of these pairs into `result`, which has only stage times so
// far. Adds the distance of each pair of two different bodies, as far as the list of contacts tells
// it.
void takeExactResult(const Scene& scene, const Options& options, const std::vector<IdPair>& pairs,
                     const DetectionResult& exact, DetectionResult& result) {
  result.contacts = exact.contacts;
  result.separations_m = exact.separations_m;
  result.geometry = exact.geometry;
  result.nearest = exact.nearest;
  result.nearest_parts = exact.nearest_parts;
  result.left_out = exact.left_out;
  if (exact.cut_off) result.cutOff(exact.cut_off_because);
  result.guaranteed = result.guaranteed && exact.guaranteed;
  result.started_cold = exact.started_cold;
  result.memory_bytes = exact.memory_bytes;
  result.memory_is_whole = exact.memory_is_whole;
  result.detector_bytes = exact.detector_bytes;
  result.counters = exact.counters;
  result.counters.triangles = scene.triangleCount();
  result.stages_ms.insert(result.stages_ms.end(), exact.stages_ms.begin(), exact.stages_ms.end());
  const std::vector<BodyDistance> distances =
      distancesOf(scene, pairs, exact, options.nearest, options.nearest && !exact.cut_off);
  result.distances.insert(result.distances.end(), distances.begin(), distances.end());
}

// Adds contacts, sorted, of pairs of bodies of which `result` has none. Makes their geometry if the
// options ask for it; the vertices of their bodies must be on the host. No pair of bodies has
// contacts in both lists, so one pass merges them.
void mergeContacts(const Scene& scene, const Options& options,
                   const std::vector<ListedContact>& contacts, DetectionResult& result) {
  const bool has_separations = listsNearPairs(scene, options);
  // The exact part may have no margin where the whole scene has one.
  if (has_separations) result.separations_m.resize(result.contacts.size());
  if (contacts.empty()) return;
  // Geometry is all or nothing: if one of the lists lacks it, the merged result has none.
  const bool had_all_geometry = result.geometry.size() == result.contacts.size();
  DetectionResult added;
  added.contacts.reserve(contacts.size());
  for (const ListedContact& contact : contacts) {
    added.contacts.push_back(contact.pair);
    if (has_separations) added.separations_m.push_back(contact.separation_m);
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
  if (has_separations) mergeBeside(from_second, added.separations_m, result.separations_m);
  if (options.geometry && had_all_geometry && added.geometry.size() == contacts.size()) {
    mergeBeside(from_second, added.geometry, result.geometry);
  } else {
    result.geometry.clear();
  }
}

// Returns whether bounds may answer: only in discrete detection with a tolerance or a deadline. All
// other cycles go to the exact detector unchanged.
bool isBounded(const Options& options) {
  return options.motion == Motion::kInstant &&
         (options.tolerance_m > 0 || options.limits.deadline != SteadyTime::max());
}

bool isInAny(const std::vector<IdPair>& pairs, BodyId id) {
  return std::any_of(pairs.begin(), pairs.end(),
                     [id](const IdPair& pair) { return pair.first == id || pair.second == id; });
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
  if (part_.disabledParts() != scene.disabledParts()) {
    part_.enableAllParts();
    for (const PartPair& pair : scene.disabledParts()) {
      part_.setPartPairEnabled(pair.body_a, pair.part_a, pair.body_b, pair.part_b, false);
    }
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
  if (copied.topology_revision != body.topology_revision ||
      copied.parts_revision != body.parts_revision) {
    part_.setParts(id, body.parts);
  }
  copied = {body.topology_revision, body.vertices_revision, body.parts_revision};
  part_.setPose(id, body.pose);
  part_.setMargin(id, body.margin_m);
}

// Pairs of two bodies with tilings are searched by their tiles; the exact detector has the others.
void BoundedCycle::sharePairs(const Scene& scene) {
  tiled_pairs_.clear();
  exact_pairs_.clear();
  tiling_.assign(scene.bodyCount(), nullptr);
  std::vector<bool> is_new(scene.bodyCount(), true);
  const auto hasTiling = [&](BodyId id) {
    const Body& body = scene.body(id);
    if (is_new[id] && !body.device_vertices) tiling_[id] = tilings_->of(body);
    is_new[id] = false;
    return tiling_[id] != nullptr;
  };
  for (const IdPair& pair : scene.enabledPairs()) {
    bool is_tiled = false;
    if (pair.first != pair.second) {
      const bool first = hasTiling(pair.first);  // asks for both, so that both are made
      is_tiled = hasTiling(pair.second) && first;
    }
    (is_tiled ? tiled_pairs_ : exact_pairs_).push_back(pair);
  }
}

// Runs the exact detector with a deadline that is early enough for it to end in time.
const DetectionResult& BoundedCycle::runExact(const Scene& scene, Options options) {
  const SteadyTime begin = std::chrono::steady_clock::now();
  options.limits.deadline = exact_ends_.earlier(options.limits.deadline);
  const DetectionResult& result = exact_(scene, options);
  exact_ends_.ended(begin);
  return result;
}

const DetectionResult& BoundedCycle::detect(const Scene& scene, const Options& options) {
  requireValid(options);
  owns_result_ = false;
  if (!isBounded(options)) return exact_(scene, options);
  sharePairs(scene);
  if (tiled_pairs_.empty()) return runExact(scene, options);
  owns_result_ = true;
  const Stopwatch cycle;
  Stopwatch watch;
  const CycleLimit limit(options.limits);
  result_.begin(scene, options, options.tolerance_m == 0 && isGuaranteed(options));
  const SteadyTime now = std::chrono::steady_clock::now();
  const SteadyTime deadline = options.limits.deadline;
  // At least half of the time is for the search, however long merging took in earlier cycles.
  const SteadyTime end = std::max(merge_time_.earlier(deadline), now + (deadline - now) / 2);
  SteadyTime first_turn = end;  // the exact detector has what is left after it
  if (end != SteadyTime::max() && !exact_pairs_.empty()) first_turn = now + (end - now) / 2;
  threads_.run(options.threads, [&] {
    SearchGoal goal;
    goal.tolerance_m = options.tolerance_m;
    goal.nearest = options.nearest;
    rounds_.begin(scene,
                  searchesOf(scene, tiled_pairs_, options.nearest && options.nearest_by_part),
                  tiling_, goal, limit);
    rounds_.decide(limit, first_turn);
  });
  double bounds_ms = watch.lapMs();
  const DetectionResult* exact = nullptr;
  if (!exact_pairs_.empty()) {
    Options exact_options = options;
    exact_options.limits.deadline = end;
    exact = &runExact(exact_part_.sceneOf(scene, exact_pairs_), exact_options);
  }
  watch.lapMs();
  threads_.run(options.threads, [&] { rounds_.decide(limit, end); });
  bounds_ms += watch.lapMs();
  result_.stages_ms.emplace_back("bounds", bounds_ms);
  if (options.tolerance_m == 0) {
    const bool near_pairs = options.near_pairs || !options.nearest;
    threads_.run(options.threads, [&] { rounds_.list(limit, end, near_pairs); });
    result_.stages_ms.emplace_back("list", watch.lapMs());
  }
  result_.detect_ms = cycle.elapsedMs();
  // `end` left time for the rest of the cycle. merge_time_ learns how long that takes.
  const SteadyTime merge_begin = std::chrono::steady_clock::now();
  if (exact != nullptr) takeExactResult(scene, options, exact_pairs_, *exact, result_);
  addBounds(scene, options, limit);
  merge_time_.took(std::chrono::steady_clock::now() - merge_begin);
  result_.round_trip_ms = cycle.elapsedMs();
  return result_;
}

// Adds what the search found to the exact detector's part of the result.
void BoundedCycle::addBounds(const Scene& scene, const Options& options, const CycleLimit& limit) {
  for (const BodyDistance& distance : rounds_.distances()) {
    const PairDecision decision = decide(distance, scene, options.tolerance_m);
    // With a tolerance a pair is done when it is decided; without, when all its contacts are
    // listed.
    const bool is_done =
        options.tolerance_m > 0 ? decision != PairDecision::kOpen : distance.is_listed;
    if (!is_done) result_.cutOff(limit.wasOver() ? limit.why() : kNoTime);
    result_.distances.push_back(distance);
  }
  const auto by_bodies = [](const BodyDistance& x, const BodyDistance& y) {
    return x.body_a != y.body_a ? x.body_a < y.body_a : x.body_b < y.body_b;
  };
  std::sort(result_.distances.begin(), result_.distances.end(), by_bodies);
  const std::vector<ListedContact> contacts = rounds_.contacts();
  for (const ListedContact& contact : contacts) {
    // The distances have an entry for each pair that was searched, so the bodies of the contact are
    // found.
    BodyDistance key;
    key.body_a = contact.pair.body_a;
    key.body_b = contact.pair.body_b;
    ++std::lower_bound(result_.distances.begin(), result_.distances.end(), key, by_bodies)
          ->contact_count;
  }
  mergeContacts(scene, options, contacts, result_);
  rounds_.addNearest(scene, result_);
  if (!rounds_.allPartsSearched()) result_.cutOff(limit.wasOver() ? limit.why() : kNoTime);
  countRejected(scene);
}

// Counts rejected triangles of the bodies that the exact detector did not see. All bodies are
// counted if it was cut off, because it may not have come to all of its bodies, and if parts
// matter, because some parts may have no pair among its pairs.
void BoundedCycle::countRejected(const Scene& scene) {
  const bool counts_all = scene.partsMatter() || result_.cut_off;
  std::vector<BodyId> unknown;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const bool was_seen = !counts_all && isInAny(exact_pairs_, id);
    if (isInAny(tiled_pairs_, id) && !was_seen && rounds_.mayReject(id)) unknown.push_back(id);
  }
  if (unknown.empty()) {
    listRejectedParts(scene, Motion::kInstant, result_);
    return;
  }
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(scene);
  if (counts_all) {
    result_.counters.rejected = 0;
    unknown.resize(scene.bodyCount());
    std::iota(unknown.begin(), unknown.end(), BodyId{0});
  }
  for (const BodyId id : unknown) result_.counters.rejected += rejected[id].count;
  listRejectedParts(rejected, result_);
}

}  // namespace deformable_contact_monitor
