// Where the shares of several devices begin and end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/scene.h"
#include "cuda/partitions/scene_partition.h"

namespace deformable_contact_monitor {

// Cuts the scene across the axis along which most of it is widest, so that all devices take as
// long; any cut is right. A sample of the vertices carries weights, which grow where a device took
// longer than the others, and so follow the material as it moves.
class ShareBounds {
 public:
  // Shares for `count` devices in the next cycle, from low to high: those of the last one, but once
  // in a while and where the scene or the count is another one. Reads the vertices on the host.
  const std::vector<SceneShare>& cut(const Scene& scene, std::size_t count);

  // What each of the shares took in that cycle [ms].
  void note(const std::vector<double>& took_ms);

 private:
  struct Sample {
    Vec3f place;  // at the last cut, in the scene frame [m]; NaN: it has none
    double weight = 1;
  };

  void place(const Scene& scene, std::size_t vertices);
  void weigh();
  int widestAxis() const;

  std::vector<Sample> samples_;  // of vertices evenly spread
  std::size_t vertices_ = 0;     // of the scene they are of
  int cycles_ = 0;               // since the last cut
  std::vector<double> took_ms_;  // the least of each share since then; empty: not known
  std::vector<SceneShare> shares_;
};

}  // namespace deformable_contact_monitor
