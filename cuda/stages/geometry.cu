// Stage output: computes the geometry of sorted contacts, by the same rule as on the host.
#include "core/rules/geometry_of_pair.h"
#include "cuda/device/check.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/rows.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

// One thread for each sorted contact: reads its triangles in the scene frame and writes its
// geometry.
__global__ void __launch_bounds__(kThreads)
    geometryKernel(CycleArrays c, SortedContacts sorted, PairGeometry* geometry) {
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  // If some row is too long, the keys have not been written.
  if (c.contacts.row_too_long[Place(0)] != 0) return;
  if (i >= sorted.most || i >= c.listedContacts()) return;
  const unsigned bits = c.params().index_bits;
  const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
  const TriangleIndex a(static_cast<std::uint32_t>(sorted.keys[i] >> bits));
  const TriangleIndex b(static_cast<std::uint32_t>(sorted.keys[i] & mask));
  geometry[i] = geometryOf(posedTriangle(c.scene, a), posedTriangle(c.scene, b),
                           sorted.separations_m != nullptr ? sorted.separations_m[i] : 0);
}

}  // namespace

void launchGeometry(const CycleArrays& cycle, const SortedContacts& sorted, PairGeometry* geometry,
                    cudaStream_t stream) {
  if (sorted.most == 0) return;
  const unsigned blocks = (sorted.most + kThreads - 1) / kThreads;
  geometryKernel<<<blocks, kThreads, 0, stream>>>(cycle, sorted, geometry);
  checkCuda(cudaGetLastError(), "a launch");
}

}  // namespace deformable_contact_monitor
