// Reads the bodies of a check: their corners, tile by tile, and the boxes that hold them.
#include "cuda/device/warp.cuh"
#include "cuda/states/state_boxes.cuh"
#include "cuda/states/state_kernels.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128;

__device__ std::uint32_t warpNumber() { return (blockIdx.x * kThreads + threadIdx.x) / kWarp; }

// One warp for each tile.
__global__ void __launch_bounds__(kThreads) cornersKernel(StateArrays s) {
  const std::uint32_t tile = warpNumber();
  if (tile >= s.tile_count) return;
  const std::uint32_t slot = tile * kWarp + laneId(), slots = s.slotCount();
  const std::uint32_t body = s.tile_body[tile];
  bool live = s.slot_triangle[slot] != kNone;
  Triangle t;
  for (int k = 0; k < 3; ++k) {
    const std::size_t vertex = live ? s.slot_vertex[std::size_t{slots} * k + slot] : 0;
    const float* const v = s.vertices + 3 * vertex;
    t.v[k] = live ? Vec3f{v[0], v[1], v[2]} : Vec3f();
  }
  live = live && isFinite(t);
  const unsigned received = __ballot_sync(kFullWarp, live);
  if (s.bodies[body].moved == kNone) {
    const RigidTransform& pose = s.still_pose[body];
    const bool is_identity = isIdentityPose(pose);
    for (Vec3f& v : t.v) v = posedVertex(pose, is_identity, v);
  }
  live = live && isFinite(t);
  for (int k = 0; k < 3; ++k) {
    float* const row = s.corner + std::size_t{3} * k * slots + slot;
    row[0] = t.v[k].x;
    row[slots] = t.v[k].y;
    row[std::size_t{2} * slots] = t.v[k].z;
  }
  const unsigned mask = __ballot_sync(kFullWarp, live);
  const Aabb box = warpBox(live ? boxOf(t) : Aabb());
  const int first = mask == 0 ? 0 : __ffs(static_cast<int>(mask)) - 1;
  const Vec3f point = laneVector(t.v[0], first);
  const std::uint32_t least = ~warpMost(live ? ~s.slot_triangle[slot] : 0);
  if (laneId() != 0) return;
  s.received[tile] = received;
  s.live[tile] = mask;
  s.tile_box[tile] = mask == 0 ? Aabb() : box;
  s.tile_point[tile] = point;
  s.tile_least[tile] = least;
}

// One warp for each region.
__global__ void __launch_bounds__(kThreads) regionsKernel(StateArrays s) {
  const std::uint32_t region = warpNumber();
  if (region >= s.region_count) return;
  const StateRegion tiles = s.regions[region];
  const bool there = laneId() < tiles.tile_count;
  const Aabb own = there ? s.tile_box[tiles.first_tile + laneId()] : Aabb();
  const Aabb box = warpBox(own);
  if (laneId() == 0) s.region_box[region] = box;
}

// One warp for each body.
__global__ void __launch_bounds__(kThreads) bodiesKernel(StateArrays s) {
  const std::uint32_t body = warpNumber();
  if (body >= s.body_count) return;
  Aabb own;
  for (std::uint32_t i = laneId(); i < s.bodies[body].region_count; i += kWarp) {
    const Aabb box = s.region_box[s.bodies[body].first_region + i];
    if (!box.empty()) own.include(box);
  }
  const Aabb box = warpBox(own);
  if (laneId() == 0) s.body_box[body] = box;
}

// One warp for each moved body in each state: notes whether its pose takes a vertex that was
// received finite beyond float32. The box of the body nearly always shows that it does not.
__global__ void __launch_bounds__(kThreads) leavesKernel(StateArrays s) {
  const std::uint32_t warp = warpNumber();
  const std::uint32_t state = warp / s.moved_count, moved = warp % s.moved_count;
  if (state >= s.state_count || s.moved_body[moved] == kNone) return;
  const std::uint32_t body = s.moved_body[moved];
  if (QuickPose(s, body, state).isBounded(s.body_box[body])) return;
  const StateBody& tiles = s.bodies[body];
  bool leaves = false;
  for (std::uint32_t i = 0; i < tiles.tile_count; ++i) {
    const std::uint32_t tile = tiles.first_tile + i;
    const bool was_finite = (s.received[tile] >> laneId() & 1) != 0;
    const Triangle t = posedSlot(s, state, body, tile * kWarp + laneId());
    leaves = leaves || (was_finite && !isFinite(t));
  }
  if (__any_sync(kFullWarp, leaves) != 0 && laneId() == 0) s.leaves_floats[state] = 1;
}

unsigned blocksFor(std::uint64_t warps) {
  return static_cast<unsigned>((warps * kWarp + kThreads - 1) / kThreads);
}

}  // namespace

void launchStateBodies(const StateArrays& arrays, cudaStream_t stream) {
  if (arrays.tile_count == 0) return;
  cornersKernel<<<blocksFor(arrays.tile_count), kThreads, 0, stream>>>(arrays);
  regionsKernel<<<blocksFor(arrays.region_count), kThreads, 0, stream>>>(arrays);
  bodiesKernel<<<blocksFor(arrays.body_count), kThreads, 0, stream>>>(arrays);
  checkCuda(cudaGetLastError(), "the kernels that read the bodies of a check");
}

void launchStateLeaves(const StateArrays& arrays, cudaStream_t stream) {
  const std::uint64_t warps = std::uint64_t{arrays.state_count} * arrays.moved_count;
  leavesKernel<<<blocksFor(warps), kThreads, 0, stream>>>(arrays);
  checkCuda(cudaGetLastError(), "the kernel that looks for vertices beyond float32");
}

}  // namespace deformable_contact_monitor
