// Stage `cluster`: prototypes, the centres of clusters, follow the scene.
//
// PrototypeTracker moves the prototypes by fuzzy c-means from cycle to cycle. Prototypes holds them
// in the form that the stage `assign` searches. Where prototypes lie changes the speed, never the
// result: the half-space rule (rules/half_space.h) is complete for any prototypes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/size_split.h"
#include "core/cpu/transform.h"
#include "core/options.h"
#include "core/rules/clustering.h"
#include "core/rules/half_space.h"

namespace deformable_contact_monitor {

// The prototypes of one cycle, each with the list of those nearest to it.
class Prototypes {
 public:
  // Takes at least one prototype in scaled coordinates. Of those that coincide it keeps one. Once
  // the limit is over, the content is unspecified.
  void build(const std::vector<Vec3f>& prototypes, const CycleLimit& limit = noLimit());

  PrototypesView view() const {
    return {points_.data(), list_reach_.data(), neighbours_.data(), neighbour_cluster_.data(),
            static_cast<std::uint32_t>(points_.size())};
  }
  std::size_t size() const { return points_.size(); }

 private:
  void listNeighbours(std::size_t g, std::vector<std::pair<float, std::uint32_t>>& others);

  std::vector<Vec3f> points_;
  std::vector<float> list_reach_;
  std::vector<Neighbour> neighbours_;
  std::vector<std::uint32_t> neighbour_cluster_;
};

// Returns the centroids of the regular triangles that `sampling` selects, in the order of their
// list [scaled]. Of moving triangles they are those halfway through the time interval.
template <class Primitive = Triangle>
std::vector<Vec3f> sampleCentroids(const WorkingSet& set, const SizeSplit& split,
                                   const Sampling& sampling);

// Keeps the prototypes from cycle to cycle.
class PrototypeTracker {
 public:
  // The next cycle starts cold.
  void clear() { prototypes_.clear(); }

  // Runs fuzzy c-means on a sample of the centroids, starting from the last cycle's prototypes if
  // their number is still the wanted one. Between refreshes the prototypes stay where they are in
  // the scene. Once the limit is over, they stay too, and the content of `searchable` is
  // unspecified. Returns true if it started cold, without prototypes of an earlier cycle.
  template <class Primitive>
  bool update(const WorkingSet& set, const SizeSplit& split, const Options& options,
              const CycleLimit& limit, Prototypes& searchable);

 private:
  std::vector<Vec3d> prototypes_;  // scene frame [m], at the end of the time interval
  int cycles_since_refresh_ = 0;
};

}  // namespace deformable_contact_monitor
