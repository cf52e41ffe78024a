// Chooses the nearest triangles of each state among the hits: the least distance of the bodies;
// then the least pair of bodies; then the least distance of the bare triangles, and the least
// triangles (a, b). Each step is a kernel, because it needs the result of the one before.
#include "core/rules/geometry_of_pair.h"
#include "cuda/device/warp.cuh"
#include "cuda/states/state_boxes.cuh"
#include "cuda/states/state_kernels.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128, kGeometryThreads = 64;

__device__ Key keyOfA(const StateArrays& s, const StateHit& hit) {
  return keyOf(hit.bare_m, s.slot_triangle[hit.slot_a]);
}

// How many of the choices a hit has passed: 0 if others are nearer.
__device__ int choicesPassed(const StateArrays& s, const StateHit& hit, int most) {
  const std::uint32_t state = hit.state;
  if (__float_as_uint(hit.apart_m) != s.apart[state]) return 0;
  if (most == 1 || hit.pair != s.best_pair[state]) return 1;
  if (most == 2 || keyOfA(s, hit) != s.best_a[state]) return 2;
  if (most == 3 || s.slot_triangle[hit.slot_b] != s.best_b[state]) return 3;
  return 4;
}

__global__ void __launch_bounds__(kThreads) chooseKernel(StateArrays s, int choice) {
  const std::uint32_t count = min(s.counters->hits, s.hits_size), step = gridDim.x * kThreads;
  for (std::uint32_t i = blockIdx.x * kThreads + threadIdx.x; i < count; i += step) {
    const StateHit hit = s.hits[i];
    if (choicesPassed(s, hit, choice) < choice) continue;
    switch (choice) {
      case 1:
        atomicMin(&s.best_pair[hit.state], hit.pair);
        break;
      case 2:
        atomicMin(&s.best_a[hit.state], keyOfA(s, hit));
        break;
      case 3:
        atomicMin(&s.best_b[hit.state], s.slot_triangle[hit.slot_b]);
        break;
      default: {
        StateNearest& found = s.found[hit.state];
        found.pair = hit.pair;
        found.slot_a = hit.slot_a;
        found.slot_b = hit.slot_b;
        found.bare_m = hit.bare_m;
      }
    }
  }
}

// One thread for each state: the points and the normal, as nearestPairOf() gives them.
__global__ void __launch_bounds__(kGeometryThreads) pointsKernel(StateArrays s) {
  const std::uint32_t state = blockIdx.x * kGeometryThreads + threadIdx.x;
  if (state >= s.state_count) return;
  StateNearest& found = s.found[state];
  if (found.pair == kNone) return;
  const DeviceStatePair& pair = s.pairs[found.pair];
  const PairGeometry geometry =
      generalGeometryOf(posedSlot(s, state, pair.a, found.slot_a),
                        posedSlot(s, state, pair.b, found.slot_b), found.bare_m);
  found.point_a = geometry.point_a;
  found.point_b = found.bare_m > 0 ? geometry.point_b : geometry.point_a;
  found.normal = found.bare_m > 0 ? geometry.normal : Vec3f();
}

// `again`: keeps the distances and what touches.
__global__ void __launch_bounds__(kThreads) startKernel(StateArrays s, bool again) {
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  if (i == 0) *s.counters = StateCounters{};
  if (i < s.state_count) {
    if (!again) {
      s.touches[i] = s.leaves_floats[i] = 0;
      s.apart[i] = __float_as_uint(INFINITY);
      s.first_touch[i] = s.seed_key[i] = ~Key{0};
    }
    s.best_pair[i] = s.best_b[i] = kNone;
    s.best_a[i] = ~Key{0};
    s.found[i] = StateNearest{};
    s.found[i].pair = kNone;
  }
  if (again) return;
  const std::uint64_t flags = std::uint64_t{s.state_count} * s.pair_count;
  for (std::uint64_t f = i; f < flags; f += std::uint64_t{gridDim.x} * kThreads) {
    s.pair_touches[f] = 0;
  }
}

}  // namespace

void launchStateStart(const StateArrays& arrays, cudaStream_t stream) {
  const unsigned blocks = (arrays.state_count + kThreads - 1) / kThreads;
  startKernel<<<blocks, kThreads, 0, stream>>>(arrays, false);
  checkCuda(cudaGetLastError(), "the kernel that begins a check of states");
}

void launchStateRestart(const StateArrays& arrays, cudaStream_t stream) {
  const unsigned blocks = (arrays.state_count + kThreads - 1) / kThreads;
  startKernel<<<blocks, kThreads, 0, stream>>>(arrays, true);
  checkCuda(cudaGetLastError(), "the kernel that begins a search of states again");
}

void launchStateNearest(const StateArrays& arrays, const DeviceTraits& device,
                        cudaStream_t stream) {
  for (int choice = 1; choice <= 4; ++choice) {
    chooseKernel<<<4 * device.multiprocessors, kThreads, 0, stream>>>(arrays, choice);
  }
  const unsigned blocks = (arrays.state_count + kGeometryThreads - 1) / kGeometryThreads;
  pointsKernel<<<blocks, kGeometryThreads, 0, stream>>>(arrays);
  checkCuda(cudaGetLastError(), "the kernels that choose the nearest triangles in states");
}

}  // namespace deformable_contact_monitor
