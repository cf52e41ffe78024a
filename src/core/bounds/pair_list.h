// All contacts of two bodies, tile by tile.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "core/bounds/pair_search.h"
#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {

struct ListedContact {
  TrianglePair pair;
  float separation_m;  // as in DetectionResult
};

// Of one pair of bodies. One thread's.
class PairList {
 public:
  // Until when what is found is to be sorted, by all lists together: they count it in `all_found`.
  PairList(SteadyTime until, std::atomic<std::size_t>& all_found)
      : until_(until), all_found_(all_found) {}

  // Finds all contacts of the pair, as exact detectors would, in any order, each once. False if it
  // left off before that: when the limit is over or when the time that is left is needed to sort
  // them.
  bool find(const BodyPair& bodies, const CycleLimit& limit);

  const std::vector<ListedContact>& contacts() const { return contacts_; }

 private:
  bool isTime(const CycleLimit& limit) const;
  bool addRegions(const BodyPair& bodies, const NearParts& regions, const CycleLimit& limit);
  bool addTiles(const BodyPair& bodies, const NearParts& tiles, const CycleLimit& limit);

  SteadyTime until_;
  std::atomic<std::size_t>& all_found_;
  std::vector<ListedContact> contacts_;
  std::vector<NearParts> regions_, tiles_;  // scratch
  std::vector<NearTriangles> triangles_;
};

}  // namespace deformable_contact_monitor
