// Runs a cycle in five steps: it begins the search of the tiled pairs, runs the exact detector on
// the other pairs, goes on with the search, lists contacts, and merges the results. If there is a
// deadline, the first search gets half of the time, so that every pair has some bound, and the
// exact detector gets what is left then.
#include "core/bounds/bounded_cycle.h"

#include <algorithm>
#include <chrono>

#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

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
    rounds_.begin(scene, tiled_pairs_, tiling_, options.tolerance_m, limit);
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
    threads_.run(options.threads, [&] { rounds_.list(limit, end); });
    result_.stages_ms.emplace_back("list", watch.lapMs());
  }
  result_.detect_ms = cycle.elapsedMs();
  // `end` left time for the rest of the cycle. merge_time_ learns how long that takes.
  const SteadyTime merge_begin = std::chrono::steady_clock::now();
  if (exact != nullptr) takeExactResult(scene, exact_pairs_, *exact, result_);
  addBounds(scene, options, limit);
  merge_time_.took(std::chrono::steady_clock::now() - merge_begin);
  result_.round_trip_ms = cycle.elapsedMs();
  return result_;
}

// Adds what the search found to the exact detector's part of the result.
void BoundedCycle::addBounds(const Scene& scene, const Options& options, const CycleLimit& limit) {
  for (const BodyDistance& distance : rounds_.distances()) {
    const float margin_m =
        pairMargin(scene.body(distance.body_a).margin_m, scene.body(distance.body_b).margin_m);
    const PairDecision decision = decide(distance, margin_m, options.tolerance_m);
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
  countRejected(scene);
}

// Counts rejected triangles of the bodies that the exact detector did not see.
void BoundedCycle::countRejected(const Scene& scene) {
  std::vector<BodyId> unknown;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (isInAny(tiled_pairs_, id) && !isInAny(exact_pairs_, id) && rounds_.mayReject(id)) {
      unknown.push_back(id);
    }
  }
  if (unknown.empty()) return;
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(scene);
  for (const BodyId id : unknown) result_.counters.rejected += rejected[id].count;
}

}  // namespace deformable_contact_monitor
