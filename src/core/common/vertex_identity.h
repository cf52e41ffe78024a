// Finds vertices of a mesh with equal coordinates, as received. So a polygon soup behaves like a
// welded mesh.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/host_list.h"

namespace deformable_contact_monitor {

// Keeps its hash table from call to call. One thread at a time; it uses the threads of the TBB
// arena.
class VertexIdentity {
 public:
  // Writes, for each vertex (x y z each), the least index of a vertex with equal coordinates; -0
  // equals 0. A vertex that is not finite is equal to no other. If the limit is over, the values
  // are unspecified.
  void identify(const HostList<float>& xyz, std::vector<std::uint32_t>& least_equal,
                const CycleLimit& limit = noLimit());

  // Does the same for vertices in two states, which are equal iff they are equal in both.
  void identify(const HostList<float>& xyz, const HostList<float>& earlier_xyz,
                std::vector<std::uint32_t>& least_equal, const CycleLimit& limit = noLimit());

 private:
  template <class Vertices>
  void identifyAll(const Vertices& vertices, std::size_t count,
                   std::vector<std::uint32_t>& least_equal, const CycleLimit& limit);

  std::vector<std::atomic<std::uint32_t>> table_;  // open addressing; a vertex index, or kFree
};

}  // namespace deformable_contact_monitor
