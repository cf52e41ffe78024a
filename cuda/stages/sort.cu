// Third stage: each cluster's members along its principal axes, sorted by where they begin.
#include "cuda/device/boxes.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 512;
constexpr unsigned kWarps = kThreads / kWarp;
static_assert(kBuckets % kThreads == 0);

struct ScaledMember {
  Vec3f v[3];
  float margin;
  std::uint32_t class_of_body;

  __device__ ScaledMember(const CycleView& c, const SceneScale& scale, const Member& member) {
    const DeviceBody& body = c.bodies[member.body_and_home >> 1];
    for (int k = 0; k < 3; ++k) v[k] = scale.apply(member.posed.v[k]);
    margin = body.slack / 2;
    class_of_body = body.class_of_body;
  }
};

// Where a member begins and ends along the first axis, within its class; and the class's bucket.
struct Buckets {
  std::uint32_t first, last, place;

  __device__ Buckets(const CycleParams& params, const ClusterFrame& frame, const ScaledMember& m) {
    const Interval along = project(frame.axes.axis[0], m.v, m.margin);
    first = frame.along[0](along.lo) >> params.bucket_shift;
    last = frame.along[0](along.hi) >> params.bucket_shift;
    place = m.class_of_body * (32768U >> params.bucket_shift) + first;
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

// Cuts the rows of class `rows` into chunks of a warp, and each chunk's partners into units.
__device__ void cutUnits(const CycleView& c, std::uint32_t cluster,
                         const std::uint32_t* bucket_begin, std::uint32_t buckets,
                         std::uint32_t rows, unsigned long long& overlaps) {
  const std::uint32_t mask = c.class_mask[rows], unit_columns = c.params->unit_columns;
  const std::uint32_t begin = bucket_begin[rows * buckets];
  const std::uint32_t end = bucket_begin[(rows + 1) * buckets];
  for (std::uint32_t chunk = begin + threadIdx.x / kWarp * kWarp; chunk < end; chunk += kThreads) {
    const std::uint32_t row = chunk + laneId();
    const bool live = row < end;
    const std::uint32_t key = live ? c.sweep_keys[row] : 0;
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
      if (laneId() == 0) place = atomicAdd(&c.counters->units, units);
      place = __shfl_sync(kFullWarp, place, 0);
      for (std::uint32_t u = laneId(); u < units && place + u < c.unit_capacity; u += kWarp) {
        c.units[place + u] = {cluster, chunk, min(end - chunk, kWarp) | rows << 8 | columns << 16,
                              u * unit_columns};
      }
    }
  }
}

__global__ void __launch_bounds__(kThreads, 2) sortKernel(CycleView c) {
  letNextStart();  // the kernel ahead has ended: this one is launched the usual way
  // While members are put into their buckets, each bucket's place moves on to where the next
  // begins.
  __shared__ std::uint32_t bucket_begin[kBuckets + 1];
  std::uint32_t* const place = bucket_begin + 1;
  const std::uint32_t g = blockIdx.x;
  if (g == 0) {  // for the next cycle; the stages that read them are over
    for (unsigned k = threadIdx.x; k < kSides * c.body_count; k += kThreads) c.body_boxes[k] = 0;
    if (threadIdx.x == 0) *c.far_count = 0;
  }
  const Bin bin = c.bins[g];
  const std::uint32_t count = min(countOf(c, g), bin.capacity);
  const CycleParams params = *c.params;
  const ClusterFrame frame = c.frames[g];
  for (unsigned k = threadIdx.x; k < kBuckets; k += kThreads) place[k] = 0;
  __syncthreads();

  Moments moments;
  for (std::uint32_t m = threadIdx.x; m < count; m += kThreads) {
    const ScaledMember scaled(c, params.scale, c.members[bin.begin + m]);
    atomicAdd(&place[Buckets(params, frame, scaled).place], 1U);
    moments.add((scaled.v[0] + scaled.v[1] + scaled.v[2]) * (1.0F / 3) - frame.centre);
  }
  storeMoments(moments, &c.moments[g]);
  if (count == 0) return;
  __syncthreads();
  scanBuckets(place, bin.begin);
  for (std::uint32_t m = threadIdx.x; m < count; m += kThreads) {
    const Member member = c.members[bin.begin + m];
    const std::uint32_t* vertices = c.corners + 3 * std::size_t{member.triangle};
    const uint4 ids = make_uint4(c.vertex_id[vertices[0]], c.vertex_id[vertices[1]],
                                 c.vertex_id[vertices[2]], bin.begin + m);
    const ScaledMember scaled(c, params.scale, member);
    const Buckets buckets(params, frame, scaled);
    Interval along[2], world[4];
    for (int k = 0; k < 2; ++k) {
      along[k] = project(frame.axes.axis[1 + k], scaled.v, scaled.margin);
    }
    world[0] = project({1, 0, 0}, scaled.v, scaled.margin);
    world[1] = project({0, 1, 0}, scaled.v, scaled.margin);
    world[2] = world[3] = project({0, 0, 1}, scaled.v, scaled.margin);
    const std::uint32_t to = atomicAdd(&place[buckets.place], 1U);
    c.sweep_boxes[to] = pack(frame.along + 1, along);
    c.sweep_keys[to] = buckets.first | buckets.last << 16;
    const PackedBox xy = pack(frame.world, world), z = pack(frame.world + 2, world + 2);
    c.world_boxes[to] = make_uint4(xy.lo, xy.hi, z.lo, z.hi);
    c.sweep_ids[to] = ids;
  }
  __syncthreads();
  if (threadIdx.x == 0) bucket_begin[0] = bin.begin;
  __syncthreads();
  std::uint32_t* const begin_for_sweep = c.bucket_begin + std::size_t{g} * (kBuckets + 1);
  for (unsigned k = threadIdx.x; k <= kBuckets; k += kThreads) begin_for_sweep[k] = bucket_begin[k];
  unsigned long long overlaps = 0;
  for (std::uint32_t s = 0; s < params.class_count; ++s) {
    cutUnits(c, g, bucket_begin, 32768U >> params.bucket_shift, s, overlaps);
  }
  overlaps = warpSum(overlaps);
  if (laneId() == 0 && overlaps != 0) atomicAdd(&c.counters->interval_overlaps, overlaps);
}

}  // namespace

void launchSort(const CycleView& cycle, cudaStream_t stream) {
  sortKernel<<<cycle.cluster_count, kThreads, 0, stream>>>(cycle);
}

}  // namespace deformable_contact_monitor
