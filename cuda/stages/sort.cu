// Stage sort: projects each cluster's tiles onto the cluster's principal axes and sorts them by
// where they begin along the first axis. The order is by buckets only, which is enough for the
// sweep. It then cuts the sweep into work units of similar size.
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;
constexpr unsigned kWarps = kThreads / kWarp;
static_assert(kBuckets % kThreads == 0);

// The interval of a tile along one axis, quantised.
struct PackedInterval {
  std::uint32_t lo, hi;
};

// Returns the interval of a box along an axis. `box` [scaled] contains all points of the tile, and
// its margin. The corners that are extreme along the axis follow from the signs of the axis.
__device__ PackedInterval boxAlong(const Quantiser& quantiser, const Vec3f& axis, const Aabb& box) {
  const Vec3f ends[2] = {{axis.x < 0 ? box.max.x : box.min.x, axis.y < 0 ? box.max.y : box.min.y,
                          axis.z < 0 ? box.max.z : box.min.z},
                         {axis.x < 0 ? box.min.x : box.max.x, axis.y < 0 ? box.min.y : box.max.y,
                          axis.z < 0 ? box.min.z : box.max.z}};
  const Interval along = project<2>(axis, ends, 0);
  return {quantiser(along.lo), quantiser(along.hi)};
}

// The sums that a thread collects over the tiles of a cluster.
struct ClusterSums {
  Moments moments;
  std::uint32_t triangles = 0;

  // Adds a box as if the material were evenly spread over it.
  __device__ void add(const Aabb& box, const Vec3f& about) {
    moments.add((box.min + box.max) * 0.5F - about);
    const Vec3f size = box.max - box.min;
    moments.product[0] += size.x * size.x / 12;
    moments.product[3] += size.y * size.y / 12;
    moments.product[5] += size.z * size.z / 12;
  }
};

// Projects a tile and stores its packed box. Returns its bucket among those of all groups.
__device__ std::uint32_t projectTile(const CycleArrays& c, const CycleParams& params,
                                     const ClusterFrame& frame, EntryIndex at, ClusterSums& sums) {
  const TileIndex tile = c.tiles.bin_entries[at];
  const TileState state = c.tiles.states[tile];
  const std::uint32_t group = c.scene.bodies[c.scene.tile_body[tile]].group;
  const Aabb box{params.scale.apply(state.box.min), params.scale.apply(state.box.max)};
  sums.add(box, frame.centre);
  sums.triangles += __popc(state.live);
  PackedInterval along[3];
  for (int k = 0; k < 3; ++k) along[k] = boxAlong(frame.along[k], frame.axes.axis[k], box);
  const std::uint32_t first = along[0].lo >> params.bucket_shift;
  const std::uint32_t last = along[0].hi >> params.bucket_shift;
  c.sweep.projected[at] = make_uint4(first | last << 16, along[1].lo | along[2].lo << 16,
                                     along[1].hi | along[2].hi << 16 | kPackedGuard, tile.value);
  return group * params.bucketsOfGroup() + first;
}

// Replaces the counts of the buckets by their first places, from `first` on: an exclusive prefix
// sum. Called by the whole block.
__device__ void scanBuckets(std::uint32_t* place, std::uint32_t first) {
  __shared__ std::uint32_t warp_total[kWarps];
  constexpr unsigned kEach = kBuckets / kThreads;
  std::uint32_t count[kEach], sum = 0;
  for (unsigned k = 0; k < kEach; ++k) sum += count[k] = place[threadIdx.x * kEach + k];
  std::uint32_t total, begin = warpPrefix(sum, total);
  if (laneId() == 0) warp_total[threadIdx.x / kWarp] = total;
  __syncthreads();
  begin += first;
  for (unsigned w = 0; w < threadIdx.x / kWarp; ++w) begin += warp_total[w];
  for (unsigned k = 0; k < kEach; ++k) {
    place[threadIdx.x * kEach + k] = begin;
    begin += count[k];
  }
  __syncthreads();
}

// Stores the sum of all threads' moments. Called by the whole block.
__device__ void storeMoments(Moments m, Moments* out) {
  __shared__ double part[kWarps][10];
  double* const term[10] = {&m.sum[0],     &m.sum[1],     &m.sum[2],     &m.product[0],
                            &m.product[1], &m.product[2], &m.product[3], &m.product[4],
                            &m.product[5], &m.count};
  for (int k = 0; k < 10; ++k) {
    const double sum = warpSum(*term[k]);
    if (laneId() == 0) part[threadIdx.x / kWarp][k] = sum;
  }
  __syncthreads();
  static_assert(sizeof(Moments) == 10 * sizeof(double));
  if (threadIdx.x < 10) {
    double sum = 0;
    for (unsigned w = 0; w < kWarps; ++w) sum += part[w][threadIdx.x];
    reinterpret_cast<double*>(out)[threadIdx.x] = sum;
  }
}

// Copies a projected tile to the next place of its bucket.
__device__ void layOut(const CycleArrays& c, const CycleParams& params, EntryIndex at,
                       std::uint32_t* place) {
  const uint4 projected = c.sweep.projected[at];
  const TileIndex tile(projected.w);
  const std::uint32_t group = c.scene.bodies[c.scene.tile_body[tile]].group;
  const std::uint32_t bucket = group * params.bucketsOfGroup() + (projected.x & 0xffffU);
  const SortedIndex to(atomicAdd(&place[bucket], 1U));
  c.sweep.keys[to] = projected.x;
  c.sweep.boxes[to] = {projected.y, projected.z};
  c.sweep.tiles[to] = tile;
}

// Cuts the rows of group `rows` into chunks of 32, and the partners of each chunk into work units.
// Warps take the chunks in turn. Called by the whole block.
__device__ void cutUnits(const CycleArrays& c, ClusterIndex cluster,
                         const std::uint32_t* bucket_begin, std::uint32_t buckets,
                         std::uint32_t rows) {
  const std::uint32_t mask = c.scene.group_mask[Place(rows)];
  const std::uint32_t unit_columns = c.params().unit_columns;
  const std::uint32_t begin = bucket_begin[rows * buckets];
  const std::uint32_t end = bucket_begin[(rows + 1) * buckets];
  for (std::uint32_t chunk = begin + threadIdx.x / kWarp * kWarp; chunk < end; chunk += kThreads) {
    const SortedIndex row(chunk + laneId());
    const bool live = row.value < end;
    const std::uint32_t key = live ? c.sweep.keys[row] : 0;
    for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) {
      const auto columns = static_cast<std::uint32_t>(__ffs(static_cast<int>(rest)) - 1);
      std::uint32_t length = 0;
      if (live) {
        const ColumnRange range = columnsOf(bucket_begin, buckets, rows, columns, row, key);
        length = range.end - range.begin;
      }
      const std::uint32_t units = (warpMost(length) + unit_columns - 1) / unit_columns;
      if (units == 0) continue;
      std::uint32_t place = 0;
      if (laneId() == 0) place = reserve(&c.counters().units, units);
      place = __shfl_sync(kFullWarp, place, 0);
      for (std::uint32_t u = laneId(); u < units && place + u < c.sweep.units.size(); u += kWarp) {
        c.sweep.units[Place(place + u)] = {cluster, SortedIndex(chunk),
                                           min(end - chunk, kWarp) | rows << 8 | columns << 16,
                                           u * unit_columns};
      }
    }
  }
}

// Projects the cluster's tiles, and counts the tiles of each bucket in `place`. Called by the whole
// block.
__device__ void projectTiles(const CycleArrays& c, const CycleParams& params, ClusterIndex g,
                             std::uint32_t first, std::uint32_t count, std::uint32_t* place) {
  __shared__ std::uint32_t triangles;
  if (threadIdx.x == 0) triangles = 0;
  const ClusterFrame frame = c.sweep.frames[g];
  __syncthreads();
  ClusterSums sums;
  for (std::uint32_t m = threadIdx.x; m < count; m += kThreads) {
    atomicAdd(&place[projectTile(c, params, frame, EntryIndex(first + m), sums)], 1U);
  }
  const std::uint32_t of_warp = warpSum(sums.triangles);
  if (laneId() == 0) atomicAdd(&triangles, of_warp);
  storeMoments(sums.moments, &c.sweep.moments[g]);  // synchronises the block
  if (threadIdx.x == 0 && triangles > 0) {
    atomicAdd(&c.counters().cluster_entries, 1ULL * triangles);
    atomicMax(&c.counters().largest_cluster, triangles);
  }
}

// One block for each cluster: sorts its entries into buckets by a counting sort, writes its part of
// the arrays of `sweep`, and adds to sweep.units.
__global__ void __launch_bounds__(kThreads) sortKernel(CycleArrays c) {
  letNextKernelStart();  // the previous kernel has ended, for this launch is a plain one
  // While tiles are put into their buckets, the place of each bucket moves on to where the next
  // bucket begins. So the array is shifted by one element.
  __shared__ std::uint32_t bucket_begin[kBuckets + 1];
  std::uint32_t* const place = bucket_begin + 1;
  const ClusterIndex g(blockIdx.x);
  const std::uint32_t first = c.tiles.bins[g].begin;
  const std::uint32_t count = c.tiles.present(g);
  const CycleParams params = c.params();
  for (unsigned k = threadIdx.x; k < kBuckets; k += kThreads) place[k] = 0;
  projectTiles(c, params, g, first, count, place);
  if (count == 0) return;
  __syncthreads();
  scanBuckets(place, first);
  for (std::uint32_t m = threadIdx.x; m < count; m += kThreads) {
    layOut(c, params, EntryIndex(first + m), place);
  }
  __syncthreads();
  if (threadIdx.x == 0) bucket_begin[0] = first;
  __syncthreads();
  std::uint32_t* const begin_for_sweep = c.sweep.bucket_begin.row(g);
  for (unsigned k = threadIdx.x; k <= kBuckets; k += kThreads) begin_for_sweep[k] = bucket_begin[k];
  for (std::uint32_t s = 0; s < params.group_count; ++s) {
    cutUnits(c, g, bucket_begin, params.bucketsOfGroup(), s);
  }
}

// Returns a quantiser for the range of 2.5 standard deviations around the mean. Points outside the
// range are clamped, which is correct but less selective.
__device__ Quantiser around(double mean, double variance) {
  const double reach = 2.5 * sqrt(variance > 0 ? variance : 0);
  return {static_cast<float>(mean - reach), static_cast<float>(mean + reach)};
}

// One thread for each cluster: reads sweep.moments, and writes the principal axes and extents to
// sweep.frames. A cluster without entries keeps its frame.
__global__ void __launch_bounds__(kWarp) frameKernel(CycleArrays c) {
  const ClusterIndex g(blockIdx.x * kWarp + threadIdx.x);
  if (g.value >= c.clusters.count) return;
  const Moments m = c.sweep.moments[g];
  if (!(m.count > 0)) return;
  const Covariance covariance = covarianceOf(m);
  const Vec3f about = c.sweep.frames[g].centre;
  const double origin[3] = {about.x, about.y, about.z};
  const double* mean = covariance.mean;
  ClusterFrame frame;
  frame.axes = principalAxes(covariance);
  frame.centre = about + Vec3f{static_cast<float>(mean[0]), static_cast<float>(mean[1]),
                               static_cast<float>(mean[2])};
  for (int k = 0; k < 3; ++k) {
    const double a[3] = {frame.axes.axis[k].x, frame.axes.axis[k].y, frame.axes.axis[k].z};
    double centre = 0, variance = 0;
    for (int i = 0; i < 3; ++i) {
      centre += a[i] * (mean[i] + origin[i]);
      for (int j = 0; j < 3; ++j) variance += a[i] * a[j] * covariance.product[i][j];
    }
    frame.along[k] = around(centre, variance);
  }
  c.sweep.frames[g] = frame;
}

}  // namespace

void launchSort(const CycleArrays& cycle, const CycleShape& /*shape*/, cudaStream_t stream) {
  if (cycle.usesBruteForce()) return;
  sortKernel<<<cycle.clusters.count, kThreads, 0, stream>>>(cycle);
}

void launchSortFrames(const CycleArrays& cycle, const CycleShape& /*shape*/, cudaStream_t stream) {
  if (cycle.usesBruteForce()) return;
  frameKernel<<<(cycle.clusters.count + kWarp - 1) / kWarp, kWarp, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
