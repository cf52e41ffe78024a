// Finds how far the bodies of a scene are from each other, and where they are nearest.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/bounds/pair_rounds.h"
#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/options.h"
#include "core/scene.h"
#include "core/tiling_cache.h"

namespace deformable_contact_monitor {

// One per detector; one thread at a time calls it, and it uses the threads of the TBB arena in
// which it is called. What it finds depends on neither the number of threads nor earlier cycles.
class DistanceSearch {
 public:
  // `tilings` may be shared with others that are called from the same thread.
  explicit DistanceSearch(std::shared_ptr<TilingCache> tilings) : tilings_(std::move(tilings)) {}

  // Fills result.nearest if options.nearest is set. The contacts of the cycle must be in the
  // result: where their list is complete, it tells which bodies touch, and only the other pairs are
  // searched. With swept motion all pairs are searched at the present moment. Once the limit is
  // over, pairs may be missing. The vertices of the scene must be on the host. Several searches may
  // share `rounds`, which keeps only the tiles of bodies.
  void find(const Scene& scene, const Options& options, const CycleLimit& limit, PairRounds& rounds,
            DetectionResult& result);

  // Forgets what earlier cycles left.
  void forget() { last_.clear(); }

 private:
  std::shared_ptr<TilingCache> tilings_;
  std::vector<PairRounds::Last> last_;
};

}  // namespace deformable_contact_monitor
