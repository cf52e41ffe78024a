#include "core/bounded_detector.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/bounds/distance_rounding.h"
#include "core/bounds/late_ends.h"
#include "core/bounds/merged_contacts.h"
#include "core/bounds/pair_rounds.h"
#include "core/bounds/rest_scene.h"
#include "core/bounds/usual_time.h"
#include "core/common/rejected_triangles.h"
#include "core/common/stopwatch.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

bool isBounded(const Options& options) {
  return options.motion == Motion::kInstant &&
         (options.tolerance_m > 0 || options.limits.deadline != SteadyTime::max());
}

class BoundedDetector : public Detector {
 public:
  BoundedDetector(std::unique_ptr<Detector> exact, std::shared_ptr<TilingCache> tilings)
      : exact_(std::move(exact)), tilings_(std::move(tilings)), rest_(exact_->vertexMemory()) {
    if (tilings_ == nullptr) tilings_ = std::make_shared<TilingCache>();
  }

  std::string backend() const override { return exact_->backend(); }
  std::pmr::memory_resource& vertexMemory() override { return exact_->vertexMemory(); }
  void reset() override { exact_->reset(); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  void share(const Scene& scene);
  template <class Work>
  void onThreads(const Options& options, const Work& work);
  const DetectionResult& runExact(const Scene& scene, Options options);
  void takeRest(const Scene& scene, const DetectionResult& rest);
  void addRestDistances(const Scene& scene, const DetectionResult& rest);
  void countRejected(const Scene& scene);
  void finish(const Scene& scene, const Options& options, const CycleLimit& limit);

  std::unique_ptr<Detector> exact_;
  std::shared_ptr<TilingCache> tilings_;
  RestScene rest_;
  LateEnds late_;                         // of exact_
  UsualTime tail_;                        // what is to be done when all is found
  std::optional<tbb::task_arena> arena_;  // of so many threads, as of Options::threads
  int arena_threads_ = 0;
  std::vector<std::shared_ptr<const Tiling>> tiling_;  // per body; null: there is none
  std::vector<IdPair> own_pairs_, rest_pairs_;
  PairRounds rounds_;
  DetectionResult result_;
};

// Which pairs go to whom.
void BoundedDetector::share(const Scene& scene) {
  own_pairs_.clear();
  rest_pairs_.clear();
  tiling_.assign(scene.bodyCount(), nullptr);
  std::vector<bool> is_new(scene.bodyCount(), true);
  const auto hasTiling = [&](BodyId id) {
    const Body& body = scene.body(id);
    if (is_new[id] && !body.device_vertices) tiling_[id] = tilings_->of(body);
    is_new[id] = false;
    return tiling_[id] != nullptr;
  };
  for (const IdPair& pair : scene.enabledPairs()) {
    bool own = false;
    if (pair.first != pair.second) {
      const bool first = hasTiling(pair.first);  // both are asked for, so that both are made
      own = hasTiling(pair.second) && first;
    }
    (own ? own_pairs_ : rest_pairs_).push_back(pair);
  }
}

template <class Work>
void BoundedDetector::onThreads(const Options& options, const Work& work) {
  if (!arena_ || arena_threads_ != options.threads) {
    int threads = tbb::task_arena::automatic;
    if (options.threads > 0) threads = options.threads;
    arena_.emplace(threads);
    arena_threads_ = options.threads;
  }
  arena_->execute(work);
}

const DetectionResult& BoundedDetector::runExact(const Scene& scene, Options options) {
  const SteadyTime begin = std::chrono::steady_clock::now();
  options.limits.deadline = late_.earlier(options.limits.deadline);
  const DetectionResult& result = exact_->detect(scene, options);
  late_.ended(begin);
  return result;
}

const DetectionResult& BoundedDetector::detect(const Scene& scene, const Options& options) {
  requireValid(options);
  if (!isBounded(options)) return exact_->detect(scene, options);
  share(scene);
  if (own_pairs_.empty()) return runExact(scene, options);
  const Stopwatch cycle;
  Stopwatch watch;
  const CycleLimit limit(options.limits);
  result_.begin(scene, options, options.tolerance_m == 0 && isGuaranteed(options));
  const SteadyTime now = std::chrono::steady_clock::now();
  const SteadyTime deadline = options.limits.deadline;
  // Half of the time at least is for deciding, whatever held the machine up lately.
  const SteadyTime end = std::max(tail_.earlier(deadline), now + (deadline - now) / 2);
  SteadyTime turn = end;  // the rest's part is what is left then
  if (end != SteadyTime::max() && !rest_pairs_.empty()) turn = now + (end - now) / 2;
  onThreads(options, [&] {
    rounds_.begin(scene, own_pairs_, tiling_, options.tolerance_m, limit);
    rounds_.decide(limit, turn);
  });
  double bounds_ms = watch.lapMs();
  const DetectionResult* rest = nullptr;
  if (!rest_pairs_.empty()) {
    Options rest_options = options;
    rest_options.limits.deadline = end;
    rest = &runExact(rest_.update(scene, rest_pairs_), rest_options);
  }
  watch.lapMs();
  onThreads(options, [&] { rounds_.decide(limit, end); });
  bounds_ms += watch.lapMs();
  result_.stages_ms.emplace_back("bounds", bounds_ms);
  if (options.tolerance_m == 0) {
    onThreads(options, [&] { rounds_.list(limit, end); });
    result_.stages_ms.emplace_back("list", watch.lapMs());
  }
  result_.detect_ms = cycle.elapsedMs();
  const SteadyTime tail_begin = std::chrono::steady_clock::now();
  if (rest != nullptr) takeRest(scene, *rest);
  finish(scene, options, limit);
  tail_.took(std::chrono::steady_clock::now() - tail_begin);
  result_.round_trip_ms = cycle.elapsedMs();
  return result_;
}

// What exact_ found; result_ has nothing yet but times.
void BoundedDetector::takeRest(const Scene& scene, const DetectionResult& rest) {
  result_.contacts = rest.contacts;
  result_.separations_m = rest.separations_m;
  result_.geometry = rest.geometry;
  result_.left_out = rest.left_out;
  if (rest.cut_off) result_.cutOff(rest.cut_off_because);
  result_.guaranteed = result_.guaranteed && rest.guaranteed;
  result_.started_cold = rest.started_cold;
  result_.memory_bytes = rest.memory_bytes;
  result_.counters = rest.counters;
  result_.counters.triangles = scene.triangleCount();
  result_.stages_ms.insert(result_.stages_ms.end(), rest.stages_ms.begin(), rest.stages_ms.end());
  addRestDistances(scene, rest);
}

void BoundedDetector::addRestDistances(const Scene& scene, const DetectionResult& rest) {
  std::map<IdPair, BodyDistance> distances;
  const bool all_listed = rest.guaranteed && !rest.cut_off && rest.left_out == 0;
  for (const IdPair& pair : rest_pairs_) {
    if (pair.first == pair.second) continue;
    BodyDistance& distance = distances[pair];
    distance.body_a = pair.first;
    distance.body_b = pair.second;
    distance.is_listed = all_listed;
  }
  if (distances.empty()) return;
  for (std::size_t i = 0; i < rest.contacts.size(); ++i) {
    const TrianglePair& contact = rest.contacts[i];
    const auto found = distances.find({contact.body_a, contact.body_b});
    if (found == distances.end()) continue;
    BodyDistance& distance = found->second;
    ++distance.contact_count;
    const float separation_m = rest.separations_m.empty() ? 0 : rest.separations_m[i];
    const float high_m = separation_m > 0 ? std::nextafter(separation_m, INFINITY) : 0;
    if (high_m >= distance.high_m) continue;
    distance.high_m = high_m;
    distance.witness = contact;
    if (rest.geometry.size() == rest.contacts.size()) {
      distance.point_a = rest.geometry[i].point_a;
      distance.point_b = high_m > 0 ? rest.geometry[i].point_b : rest.geometry[i].point_a;
    }
  }
  for (auto& [pair, distance] : distances) {
    if (!all_listed) {
      result_.distances.push_back(distance);
      continue;
    }
    const float margin_m =
        pairMargin(scene.body(pair.first).margin_m, scene.body(pair.second).margin_m);
    // nearVerdict() lists what is as near as the margin, to the nearest float32.
    distance.low_m =
        distance.contact_count == 0 ? margin_m : roundedDown(distance.high_m * (1 - 1e-6));
    result_.distances.push_back(distance);
  }
}

void BoundedDetector::finish(const Scene& scene, const Options& options, const CycleLimit& limit) {
  for (const BodyDistance& distance : rounds_.distances()) {
    const float margin_m =
        pairMargin(scene.body(distance.body_a).margin_m, scene.body(distance.body_b).margin_m);
    const PairDecision decision = decide(distance, margin_m, options.tolerance_m);
    const bool is_done =
        options.tolerance_m > 0 ? decision != PairDecision::kOpen : distance.is_listed;
    if (!is_done) result_.cutOff(limit.wasOver() ? limit.why() : kNoTime);
    result_.distances.push_back(distance);
  }
  const auto in_order = [](const BodyDistance& x, const BodyDistance& y) {
    return x.body_a != y.body_a ? x.body_a < y.body_a : x.body_b < y.body_b;
  };
  std::sort(result_.distances.begin(), result_.distances.end(), in_order);
  const std::vector<ListedContact> contacts = rounds_.contacts();
  for (const ListedContact& contact : contacts) {
    BodyDistance key;
    key.body_a = contact.pair.body_a;
    key.body_b = contact.pair.body_b;
    ++std::lower_bound(result_.distances.begin(), result_.distances.end(), key, in_order)
          ->contact_count;
  }
  mergeContacts(scene, options, contacts, result_);
  countRejected(scene);
}

// Of bodies that exact_ did not look at.
void BoundedDetector::countRejected(const Scene& scene) {
  const auto is_in = [](const std::vector<IdPair>& pairs, BodyId id) {
    return std::any_of(pairs.begin(), pairs.end(),
                       [id](const IdPair& pair) { return pair.first == id || pair.second == id; });
  };
  std::vector<BodyId> unknown;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (is_in(own_pairs_, id) && !is_in(rest_pairs_, id) && rounds_.mayReject(id)) {
      unknown.push_back(id);
    }
  }
  if (unknown.empty()) return;
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(scene);
  for (const BodyId id : unknown) result_.counters.rejected += rejected[id].count;
}

}  // namespace

std::unique_ptr<Detector> makeBoundedDetector(std::unique_ptr<Detector> exact,
                                              std::shared_ptr<TilingCache> tilings) {
  return std::make_unique<BoundedDetector>(std::move(exact), std::move(tilings));
}

}  // namespace deformable_contact_monitor
