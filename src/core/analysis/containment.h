// Finds parts of bodies that lie within other bodies without touching their surface. A collision
// check of surfaces alone would miss these.
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

// A component of the body `inner` (mesh_components.h) that lies within a closed component of
// `outer` and touches no triangle of that. It lies within if a ray from it crosses an odd number of
// the triangles of some layer of the closed component. README.md of this room says what that means
// for double-sided meshes, boxes that share an edge, hollow containers and nested shells.
struct InsidePart {
  BodyId inner = 0, outer = 0;
  std::uint32_t triangle = 0;  // the least index of the part's triangles
  Vec3d centroid;              // mean of the corners of its triangles [m], in the scene frame
};

struct Containment {
  // The parts are sorted by inner, outer, triangle. Each part is listed once for each outer body.
  std::vector<InsidePart> parts;
  struct Components {
    bool looked_at = false;
    std::uint32_t all = 0, open = 0;  // nothing is found within open components
  };
  std::vector<Components> bodies;  // one per body of the scene
  // Says why the search ended early, like DetectionResult::cut_off_because. It is empty if the
  // search did not. Listed parts are right even then, but others may be missing.
  std::string cut_off_because;
};

// Keeps the components of bodies from cycle to cycle. One thread at a time.
class ContainmentFinder {
 public:
  ContainmentFinder();
  ContainmentFinder(const ContainmentFinder&) = delete;
  ContainmentFinder& operator=(const ContainmentFinder&) = delete;
  ~ContainmentFinder();

  // Searches the enabled pairs of different bodies. `result` must hold all contacts of the scene,
  // neither cut off nor with some left out. If contacts of a pair are missing, parts of it that
  // touch may be listed. The answer is exact if the result is. Bodies with a vertex that their pose
  // makes infinite are within nothing and contain nothing. The answer is valid until the next call
  // or the finder's end. Throws std::invalid_argument if the vertices of a body that takes part are
  // on a device.
  const Containment& find(const Scene& scene, const DetectionResult& result,
                          const CycleLimit& limit);

 private:
  bool prepare(const Scene& scene, const CycleLimit& limit);

  std::vector<std::unique_ptr<PosedComponents>> bodies_;
  Containment containment_;
};

}  // namespace deformable_contact_monitor
