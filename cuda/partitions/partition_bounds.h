// Chooses the bounds of the partitions of several devices.
#pragma once

#include <cstddef>
#include <vector>

#include "core/scene.h"
#include "cuda/partitions/scene_partition.h"

namespace deformable_contact_monitor {

// Cuts the scene by planes across its widest axis, and moves the planes until all devices take
// equally long. Any cut gives correct results. Samples of the vertices carry weights, which grow
// where a device took longer than the others did. For one thread at a time.
class PartitionBounds {
 public:
  // Returns the partitions of `count` devices for the next cycle, from low to high. They stay the
  // same for some cycles, and are cut anew then, or at once if the scene's size or `count` has
  // changed. Reads the vertices on the host.
  const std::vector<ScenePartition>& cut(const Scene& scene, std::size_t count);

  // Notes how long each partition took in the last cycle, in the order of cut() [ms].
  void note(const std::vector<double>& took_ms);

 private:
  struct Sample {
    // The position in the scene frame at the last cut [m]; NaN if it is not known.
    Vec3f place;
    double weight = 1;
  };

  void place(const Scene& scene, std::size_t vertices);
  void weigh();
  int widestAxis() const;

  std::vector<Sample> samples_;  // of vertices that are evenly spread over their order
  std::size_t vertices_ = 0;     // of the scene that the samples are from
  int cycles_ = 0;               // since the last cut
  // The shortest time of each partition since the last cut [ms]; empty if no time is known.
  std::vector<double> took_ms_;
  std::vector<ScenePartition> partitions_;
};

}  // namespace deformable_contact_monitor
