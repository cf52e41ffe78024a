// Which parts of bodies lie within other bodies without touching them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "core/scene.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

class PosedComponents;

// A component of `inner` (mesh_components.h) that touches no triangle of some closed component of
// `outer` and lies within it: an odd number of that component's triangles is above it.
struct InsidePart {
  BodyId inner = 0, outer = 0;
  std::uint32_t triangle = 0;  // the least of the part's triangles
  Vec3d centroid;              // mean of the corners of its triangles [m], in the scene frame
};

struct Containment {
  // By inner, outer, triangle; each part once for each outer body.
  std::vector<InsidePart> parts;
  struct Components {
    bool looked_at = false;
    std::uint32_t all = 0, open = 0;  // nothing is said to be within those that are open
  };
  std::vector<Components> bodies;  // one per body of the scene
  // Why it ended early, as DetectionResult::cut_off_because; empty: it did not. What is listed
  // holds also then, but of other pairs nothing is known.
  std::string cut_off_because;
};

// Keeps the components of bodies from cycle to cycle. One thread at a time.
class ContainmentFinder {
 public:
  ContainmentFinder();
  ContainmentFinder(const ContainmentFinder&) = delete;
  ContainmentFinder& operator=(const ContainmentFinder&) = delete;
  ~ContainmentFinder();

  // Looks at the enabled pairs of different bodies. `result`: all contacts of the scene, neither
  // cut off nor with some left out; of a pair whose contacts are not all there, parts that touch
  // may be listed, too. Exact where its settings are; a contact that they lost is none here. Bodies
  // with a vertex that their pose makes infinite are within nothing and hold nothing. The answer is
  // valid until the next call or the finder's end. Throws std::invalid_argument where the vertices
  // of a body that takes part are on a device.
  const Containment& find(const Scene& scene, const DetectionResult& result,
                          const CycleLimit& limit);

 private:
  bool prepare(const Scene& scene, const CycleLimit& limit);

  std::vector<std::unique_ptr<PosedComponents>> bodies_;
  Containment containment_;
};

}  // namespace deformable_contact_monitor
