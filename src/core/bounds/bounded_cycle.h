// Runs a detection cycle that decides pairs of bodies by bounds of their distance, within a
// tolerance or before a deadline. core/detector_pool.h says what it promises.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <memory_resource>
#include <utility>
#include <vector>

#include "core/bounds/pair_rounds.h"
#include "core/bounds/time_estimates.h"
#include "core/common/cycle_limit.h"
#include "core/common/parallel.h"
#include "core/detector.h"
#include "core/scene.h"
#include "core/tiling_cache.h"

namespace deformable_contact_monitor {

// Owns the exact detector's scene: a copy of the scene that has only some of its pairs. What did
// not change since the last cycle is not copied again, and pairs that stay the same keep their
// revision, so the warm-start data of detectors stays valid.
class ExactPart {
 public:
  // `memory`: where vertices are stored. It must outlive this object.
  explicit ExactPart(std::pmr::memory_resource& memory) : memory_(&memory) {}

  // Returns a scene with these pairs alone, (a, b) with a <= b, ascending; valid until the next
  // call. Bodies keep their ids. Bodies without a pair have no triangles, and none has an earlier
  // state, because the scene is for one moment.
  const Scene& sceneOf(const Scene& scene, const std::vector<std::pair<BodyId, BodyId>>& pairs);

 private:
  // The revisions of a body when it was last copied.
  struct Copied {
    // 0: nothing was copied.
    std::uint64_t topology_revision = 0, vertices_revision = 0, parts_revision = 0;
  };

  void copy(const Body& body, BodyId id);

  std::pmr::memory_resource* memory_;
  Scene part_;
  std::vector<Copied> copied_;  // per body
};

// Shares the pairs of a cycle between bounds of tiles and an exact detector, and makes one result
// of both. Keeps what both leave for later cycles. One thread at a time.
class BoundedCycle {
 public:
  // Detects exactly. Its result stays valid until the next call.
  using ExactDetection = std::function<const DetectionResult&(const Scene&, const Options&)>;

  // `memory` stores the vertices of the scenes that `exact` gets (Detector::vertexMemory()).
  BoundedCycle(ExactDetection exact, std::shared_ptr<TilingCache> tilings,
               std::pmr::memory_resource& memory)
      : exact_(std::move(exact)), tilings_(std::move(tilings)), exact_part_(memory) {}

  // Does what Detector::detect() does. The result belongs to this object, or to `exact` if that did
  // the whole cycle.
  const DetectionResult& detect(const Scene& scene, const Options& options);

  // Returns whether the result of the last detect() belongs to this object, not to `exact`.
  bool ownsResult() const { return owns_result_; }
  // Forgets the nearest triangles of earlier cycles.
  void forget() { rounds_.forget(); }
  // Does what Detector::swapResult() does, if this object owns the result.
  void swapResult(DetectionResult& result) { result_.swap(result); }

 private:
  void sharePairs(const Scene& scene);
  const DetectionResult& runExact(const Scene& scene, Options options);
  void addBounds(const Scene& scene, const Options& options, const CycleLimit& limit);
  void countRejected(const Scene& scene);

  ExactDetection exact_;
  std::shared_ptr<TilingCache> tilings_;
  ExactPart exact_part_;
  LateEnds exact_ends_;
  UsualTime merge_time_;  // from the last contact to the end of the cycle
  Threads threads_;
  std::vector<std::shared_ptr<const Tiling>> tiling_;  // per body; null: there is none
  std::vector<std::pair<BodyId, BodyId>> tiled_pairs_, exact_pairs_;  // of this cycle, ascending
  PairRounds rounds_;
  DetectionResult result_;
  bool owns_result_ = false;
};

}  // namespace deformable_contact_monitor
