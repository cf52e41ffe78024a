// Stage `pose`, once vertices have their places and identities: which fans are certified.
#pragma once

#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/vertex_fans.h"
#include "core/cpu/transform.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Keeps what it knows of each body until its topology changes.
class FanCertifier {
 public:
  // Adds kFanCertified to the identities of vertices; of bodies that have contacts with themselves.
  // `set`: just built from the scene. Some vertices are left out if the limit was over.
  void certify(const Scene& scene, WorkingSet& set, const CycleLimit& limit);

 private:
  struct BodyFans {
    std::uint64_t topology_revision = 0;  // no body's
    VertexFans fans;
    std::vector<std::uint32_t> fours;  // its vertices, as of foursAlike()
  };

  void markRepeated(const std::uint32_t* id, std::uint32_t first, std::uint32_t count,
                    const CycleLimit& limit);
  void certifyBody(const BodyFans& body, std::uint32_t first, std::uint32_t count,
                   const CycleLimit& limit, WorkingSet& set);

  std::vector<BodyFans> bodies_;
  std::vector<char> repeated_;  // per vertex of a body: another one equals it; empty: of none
};

}  // namespace deformable_contact_monitor
