#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/parallel.h"
#include "core/common/part_table.h"
#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"
#include "core/rules/margins.h"
#include "core/state_checker.h"
#include "core/states/box_tree.h"
#include "core/states/state_input.h"
#include "core/states/state_search.h"

namespace deformable_contact_monitor {
namespace {

using IdPair = std::pair<BodyId, BodyId>;

// Keeps a tree for each body. Threads take states in rising order, a few at a time.
class CpuStateChecker : public StateChecker {
 public:
  std::string backend() const override { return "cpu"; }

  void reset() override {
    trees_.clear();
    searches_.clear();
  }

  const StateResults& check(const Scene& scene, const StateBatch& batch,
                            const StateOptions& options) override {
    const Stopwatch watch;
    requireValid(scene, batch);
    requireThreads(options.threads);
    const std::vector<IdPair> pairs = pairsOfStates(scene, batch);
    for (const auto& [a, b] : pairs) {
      for (const BodyId id : {a, b}) requireHostVertices(scene.body(id), backend());
    }
    results_ = StateResults();
    results_.states.resize(batch.count);
    results_.rejected = rejected_.of(scene, pairs);
    const CycleLimit limit(options.limits);
    threads_.run(options.threads, [&] { run(scene, batch, options, pairs, limit); });
    if (limit.wasOver() && is_open_) {
      results_.cut_off = true;
      results_.cut_off_because = limit.why();
    }
    results_.check_ms = watch.elapsedMs();
    return results_;
  }

 private:
  void run(const Scene& scene, const StateBatch& batch, const StateOptions& options,
           const std::vector<IdPair>& pairs, const CycleLimit& limit);
  bool updateTrees(const Scene& scene, const std::vector<IdPair>& pairs, const CycleLimit& limit);
  void decide(const StateTask& task, const CycleLimit& limit);

  Threads threads_;
  std::vector<std::unique_ptr<BoxTree>> trees_;         // per body; null: it is in no pair
  std::vector<std::unique_ptr<StateSearch>> searches_;  // per thread
  bool is_open_ = false;                                // the limit left some state open
  RejectedCounts rejected_;
  StateResults results_;
};

void CpuStateChecker::run(const Scene& scene, const StateBatch& batch, const StateOptions& options,
                          const std::vector<IdPair>& pairs, const CycleLimit& limit) {
  is_open_ = batch.count > 0;
  if (!updateTrees(scene, pairs, limit)) return;
  std::optional<PartTable> parts;
  if (scene.partsMatter()) parts.emplace(scene);
  StateTask task{scene, batch, options, {}, scene.anyPartMargin()};
  for (const auto& [a, b] : pairs) {
    const Body &body_a = scene.body(a), &body_b = scene.body(b);
    task.pairs.push_back({a, b, trees_[a].get(), trees_[b].get(),
                          pairMargin(body_a.margin_m, body_b.margin_m), PairRadii(body_a, body_b),
                          parts ? &*parts : nullptr});
  }
  decide(task, limit);
}

// Returns false if the limit was over.
bool CpuStateChecker::updateTrees(const Scene& scene, const std::vector<IdPair>& pairs,
                                  const CycleLimit& limit) {
  std::vector<bool> takes_part(scene.bodyCount());
  for (const auto& [a, b] : pairs) takes_part[a] = takes_part[b] = true;
  trees_.resize(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!takes_part[id]) {
      trees_[id].reset();
      continue;
    }
    if (trees_[id] == nullptr) trees_[id] = std::make_unique<BoxTree>();
    if (!trees_[id]->update(scene.body(id), limit)) return false;
  }
  return true;
}

void CpuStateChecker::decide(const StateTask& task, const CycleLimit& limit) {
  constexpr std::size_t kBlock = 8;  // states, about a millisecond
  const std::size_t count = task.batch.count;
  const std::size_t workers = std::min(threadCount(), blockCount(count, kBlock));
  while (searches_.size() < workers) searches_.push_back(std::make_unique<StateSearch>());
  std::vector<std::vector<TouchingBodies>> pairs(workers);
  std::atomic<std::size_t> next{0}, decided{0};
  parallelBlocks(workers, 1, [&](std::size_t worker, std::size_t, std::size_t) {
    StateSearch& search = *searches_[worker];
    search.begin(task, limit);
    for (std::size_t begin = next.fetch_add(kBlock); begin < count;
         begin = next.fetch_add(kBlock)) {
      for (std::size_t i = begin; i < std::min(count, begin + kBlock); ++i) {
        if (limit.over()) return;
        if (search.decide(static_cast<std::uint32_t>(i), &results_.states[i], &pairs[worker])) {
          ++decided;
        }
      }
    }
  });
  for (const auto& of_worker : pairs) {
    results_.pairs.insert(results_.pairs.end(), of_worker.begin(), of_worker.end());
  }
  std::sort(results_.pairs.begin(), results_.pairs.end());
  is_open_ = decided < count;
}

}  // namespace

std::unique_ptr<StateChecker> makeCpuStateChecker() { return std::make_unique<CpuStateChecker>(); }

}  // namespace deformable_contact_monitor
