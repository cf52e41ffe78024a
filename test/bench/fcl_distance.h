// The distance of two bodies by FCL's bounding volume hierarchies, for the benchmarks.
#pragma once

#include <memory>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// How FCL's tree follows vertices that moved.
enum class FclTree { kRebuilt, kRefitBottomUp, kRefitTopDown };

// Keeps a tree of each body of a scene, in the scene frame. All bodies must be finite, and keep
// their topology.
class FclDistance {
 public:
  FclDistance(const Scene& scene, FclTree tree);
  ~FclDistance();

  // Takes over the vertices of the bodies in `moved`, and returns the least distance of all enabled
  // pairs of two bodies [m]; negative if two of them collide.
  double leastDistance(const Scene& scene, const std::vector<BodyId>& moved);

 private:
  struct Models;
  FclTree tree_;
  std::unique_ptr<Models> models_;
};

}  // namespace deformable_contact_monitor
