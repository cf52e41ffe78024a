// Stage sort: each cluster's members along its principal axes, sorted by where they begin.
#include "core/rules/common_motion.h"
#include "core/rules/margins.h"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 512;
constexpr unsigned kWarps = kThreads / kWarp;
static_assert(kBuckets % kThreads == 0);

// With kStates == 2 in swept motion: where it was at the beginning of the step comes first, and the
// common motion is taken off.
template <int kStates>
struct ScaledMember {
  static constexpr int kPoints = 3 * kStates, kPresent = kPoints - 3;
  Vec3f v[kPoints];
  float margin;
  std::uint32_t group;

  __device__ ScaledMember(const CycleArrays& c, const SceneScale& scale, MemberIndex at,
                          const Member& member) {
    const DeviceBody& body = c.scene.bodies[member.body()];
    if (kStates > 1) {
      const Triangle earlier = c.members.earlier[at].posed;
      for (int k = 0; k < 3; ++k) v[k] = scale.apply(earlier.v[k]);
    }
    const SceneScale present =
        kStates > 1 ? withoutMotion(scale, c.scene.common_motion[Place(0)]) : scale;
    for (int k = 0; k < 3; ++k) v[kPresent + k] = present.apply(member.posed.v[k]);
    margin = body.slack / 2;
    group = body.group;
  }
  __device__ Interval along(const Vec3f& axis) const { return project<kPoints>(axis, v, margin); }
  // Of one state.
  __device__ Interval alongAt(int first, const Vec3f& axis) const {
    return project<3>(axis, v + first, margin);
  }
  __device__ Vec3f mean() const {
    if (kStates == 1) return centroidOf(v);
    return (centroidOf(v) + centroidOf(v + kPresent)) * 0.5F;
  }
};

// Where a member begins and ends along the first axis, within its group; and the group's bucket.
struct Buckets {
  std::uint32_t first, last, place;

  template <int kStates>
  __device__ Buckets(const CycleParams& params, const ClusterFrame& frame,
                     const ScaledMember<kStates>& m) {
    const Interval along = m.along(frame.axes.axis[0]);
    first = frame.along[0](along.lo) >> params.bucket_shift;
    last = frame.along[0](along.hi) >> params.bucket_shift;
    place = m.group * params.bucketsOfGroup() + first;
  }
};

// Turns counts into places from `first` on, by the whole block.
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

// The sum of all threads' moments, by the whole block.
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

// A triangle's boxes along the scene's axes, packed: in swept motion those of both states.
template <int kStates>
__device__ void putWorldBoxes(const CycleArrays& c, const ClusterFrame& frame,
                              const ScaledMember<kStates>& m, SortedIndex to) {
  constexpr int kPresent = ScaledMember<kStates>::kPresent;
  const Vec3f x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  const Interval xy_now[2] = {m.alongAt(kPresent, x), m.alongAt(kPresent, y)};
  const Interval z_now = m.alongAt(kPresent, z);
  const PackedBox xy = pack(frame.world, xy_now);
  if (kStates == 1) {
    const Interval zz[2] = {z_now, z_now};
    const PackedBox packed_z = pack(frame.world + 2, zz);
    c.sweep.world_boxes[to] = make_uint4(xy.lo, xy.hi, packed_z.lo, packed_z.hi);
  } else {
    const Interval xy_before[2] = {m.alongAt(0, x), m.alongAt(0, y)};
    const Interval zz[2] = {z_now, m.alongAt(0, z)};
    const PackedBox before = pack(frame.world, xy_before);
    c.sweep.world_boxes[to] = make_uint4(xy.lo, xy.hi, before.lo, before.hi);
    c.sweep.moving_z[to] = pack(frame.world + 2, zz);
  }
}

// Puts a member's boxes, keys and ids to its place in the order.
template <int kStates>
__device__ void layOut(const CycleArrays& c, const CycleParams& params, const ClusterFrame& frame,
                       MemberIndex at, std::uint32_t* place) {
  const Member member = c.members.members[at];
  const VertexIndex* vertices = c.scene.corners.row(member.triangle);
  const uint4 ids =
      make_uint4(c.scene.vertex_id[vertices[0]].value, c.scene.vertex_id[vertices[1]].value,
                 c.scene.vertex_id[vertices[2]].value, at.value);
  const ScaledMember<kStates> scaled(c, params.scale, at, member);
  const Buckets buckets(params, frame, scaled);
  Interval along[2];
  for (int k = 0; k < 2; ++k) along[k] = scaled.along(frame.axes.axis[1 + k]);
  const SortedIndex to(atomicAdd(&place[buckets.place], 1U));
  c.sweep.boxes[to] = pack(frame.along + 1, along);
  c.sweep.keys[to] = buckets.first | buckets.last << 16;
  putWorldBoxes(c, frame, scaled, to);
  c.sweep.ids[to] = ids;
}

// Cuts the rows of group `rows` into chunks of a warp, and each chunk's partners into units.
__device__ void cutUnits(const CycleArrays& c, ClusterIndex cluster,
                         const std::uint32_t* bucket_begin, std::uint32_t buckets,
                         std::uint32_t rows, unsigned long long& overlaps) {
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
      overlaps += length;
      const std::uint32_t units = (warpMost(length) + unit_columns - 1) / unit_columns;
      if (units == 0) continue;
      std::uint32_t place = 0;
      if (laneId() == 0) place = atomicAdd(&c.counters().units, units);
      place = __shfl_sync(kFullWarp, place, 0);
      for (std::uint32_t u = laneId(); u < units && place + u < c.sweep.units.size(); u += kWarp) {
        c.sweep.units[Place(place + u)] = {cluster, SortedIndex(chunk),
                                           min(end - chunk, kWarp) | rows << 8 | columns << 16,
                                           u * unit_columns};
      }
    }
  }
}

// A block for each cluster: reads its members; writes its part of the arrays of `sweep`, by a
// counting sort into buckets, and adds to sweep.units. In swept motion (kStates == 2) both states.
template <int kStates>
__global__ void __launch_bounds__(kThreads, 2) sortKernel(CycleArrays c) {
  letNextStart();  // the kernel ahead has ended: this one is launched the usual way
  // While members are put into their buckets, each bucket's place moves on to where the next
  // begins.
  __shared__ std::uint32_t bucket_begin[kBuckets + 1];
  std::uint32_t* const place = bucket_begin + 1;
  const ClusterIndex g(blockIdx.x);
  const std::uint32_t first = c.members.bins[g].begin;
  const std::uint32_t count = c.members.present(g);
  const CycleParams params = c.params();
  const ClusterFrame frame = c.sweep.frames[g];
  for (unsigned k = threadIdx.x; k < kBuckets; k += kThreads) place[k] = 0;
  __syncthreads();

  Moments moments;
  for (std::uint32_t m = threadIdx.x; m < count; m += kThreads) {
    const MemberIndex at(first + m);
    const ScaledMember<kStates> scaled(c, params.scale, at, c.members.members[at]);
    atomicAdd(&place[Buckets(params, frame, scaled).place], 1U);
    moments.add(scaled.mean() - frame.centre);
  }
  storeMoments(moments, &c.sweep.moments[g]);
  if (count == 0) return;
  __syncthreads();
  scanBuckets(place, first);
  for (std::uint32_t m = threadIdx.x; m < count; m += kThreads) {
    layOut<kStates>(c, params, frame, MemberIndex(first + m), place);
  }
  __syncthreads();
  if (threadIdx.x == 0) bucket_begin[0] = first;
  __syncthreads();
  std::uint32_t* const begin_for_sweep = c.sweep.bucket_begin.row(g);
  for (unsigned k = threadIdx.x; k <= kBuckets; k += kThreads) begin_for_sweep[k] = bucket_begin[k];
  unsigned long long overlaps = 0;
  for (std::uint32_t s = 0; s < params.group_count; ++s) {
    cutUnits(c, g, bucket_begin, params.bucketsOfGroup(), s, overlaps);
  }
  overlaps = warpSum(overlaps);
  if (laneId() == 0 && overlaps != 0) atomicAdd(&c.counters().interval_overlaps, overlaps);
}

__device__ Quantiser around(double mean, double variance) {
  const double reach = 2.5 * sqrt(variance > 0 ? variance : 0);
  return {static_cast<float>(mean - reach), static_cast<float>(mean + reach)};
}

// A thread for each cluster: reads sweep.moments, writes sweep.frames. A cluster without members
// keeps its frame.
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
    frame.world[k] = around(mean[k] + origin[k], covariance.product[k][k]);
  }
  frame.world[3] = frame.world[2];
  c.sweep.frames[g] = frame;
}

}  // namespace

void launchSort(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  const auto kernel = shape.swept ? sortKernel<2> : sortKernel<1>;
  kernel<<<cycle.clusters.count, kThreads, 0, stream>>>(cycle);
}

void launchSortFrames(const CycleArrays& cycle, const CycleShape& /*shape*/, cudaStream_t stream) {
  frameKernel<<<(cycle.clusters.count + kWarp - 1) / kWarp, kWarp, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
