// Stage output: computes the geometry of ordered contacts, by the same rule as on the host, and
// writes both into memory of the host.
//
// Nearly all contacts are proper crossings. They take one path, without memory besides registers.
// The others are listed by kind, so that the threads of a warp do similar work.
#include "core/rules/geometry_of_pair.h"
#include "cuda/device/check.cuh"
#include "cuda/device/warp.cuh"
#include "cuda/stages/corners.cuh"
#include "cuda/stages/rows.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 128, kWarps = kThreads / kWarp;
constexpr unsigned kWords = sizeof(PairGeometry) / sizeof(std::uint32_t);
static_assert(sizeof(PairGeometry) == 11 * sizeof(std::uint32_t), "kWords has no remainder");

// Writes the geometry of up to 32 contacts, by whole words in their order, because single fields
// would be slow over the bus. Belongs to a warp; in shared memory.
struct GeometryWriter {
  std::uint32_t words[kWarp * kWords];

  // Called by a whole warp. Lanes whose `wanted` is false write nothing.
  __device__ void write(PairGeometry* to, bool wanted, std::uint32_t place, const PairGeometry& g) {
    std::uint32_t* const own = words + laneId() * kWords;
    const float values[kWords - 1] = {g.point_a.x, g.point_a.y,   g.point_a.z, g.point_b.x,
                                      g.point_b.y, g.point_b.z,   g.normal.x,  g.normal.y,
                                      g.normal.z,  g.separation_m};
    for (unsigned k = 0; k + 1 < kWords; ++k) own[k] = __float_as_uint(values[k]);
    own[kWords - 1] = g.flags;
    const unsigned mask = __ballot_sync(kFullWarp, wanted);
    __syncwarp();
    auto* const out = reinterpret_cast<std::uint32_t*>(to);
    for (unsigned k = 0; k < kWords; ++k) {
      const unsigned word = k * kWarp + laneId(), entry = word / kWords;
      const std::size_t at = __shfl_sync(kFullWarp, place, entry);
      if ((mask >> entry & 1) != 0) out[at * kWords + word % kWords] = words[word];
    }
    __syncwarp();
  }
};

// Two triangles in the scene frame, and the separation with which they were listed [m].
struct ListedPair {
  Triangle a, b;
  float separation_m;

  __device__ ListedPair(const CycleArrays& c, const OrderedContacts& ordered,
                        const GeometryOutput& out, std::uint32_t i) {
    const unsigned bits = c.params().index_bits;
    const std::uint64_t key = ordered.keys[i], mask = (std::uint64_t{1} << bits) - 1;
    a = posedTriangle(c.scene, TriangleIndex(static_cast<std::uint32_t>(key >> bits)));
    b = posedTriangle(c.scene, TriangleIndex(static_cast<std::uint32_t>(key & mask)));
    separation_m = out.separations_m != nullptr ? out.separations_m[ordered.from[i].value] : 0;
  }
  // Returns whether all vertices of b seem to be on a's plane.
  __device__ bool seemsCoplanar() const {
    bool seems = separation_m <= 0;
    for (const Vec3f& v : b.v) {
      double permanent;
      const double volume = orient3dDouble(a.v[0], a.v[1], a.v[2], v, permanent);
      seems = seems && fabs(volume) <= detail::kEnough * permanent;
    }
    return seems;
  }
};

// One thread for each ordered contact: writes its geometry if it properly crosses, else lists it.
__global__ void __launch_bounds__(kThreads)
    crossingKernel(CycleArrays c, OrderedContacts ordered, GeometryOutput out) {
  __shared__ GeometryWriter writers[kWarps];
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  const bool is_there = i < orderedCount(c, out.most);
  if (__ballot_sync(kFullWarp, is_there) == 0) return;
  PairGeometry geometry({}, {}, {}, 0, 0);
  bool crosses = false, coplanar = false;
  if (is_there) {
    const ListedPair pair(c, ordered, out, i);
    crosses = pair.separation_m <= 0 && crossingGeometryOf(pair.a, pair.b, geometry);
    if (!crosses) coplanar = pair.seemsCoplanar();
  }
  const bool open = is_there && !crosses;
  const std::uint32_t from_front = warpReserve(out.open_count, open && coplanar);
  const std::uint32_t from_back = warpReserve(out.open_count + 1, open && !coplanar);
  if (open) out.open[coplanar ? from_front : out.most - 1 - from_back] = i;
  writers[threadIdx.x / kWarp].write(out.geometry, crosses, i, geometry);
}

// One thread for each contact that was listed, and warps of one kind. Then, or at once if none is
// left for a thread, it writes its share of the contacts.
__global__ void __launch_bounds__(kThreads)
    openKernel(CycleArrays c, OrderedContacts ordered, ContactsOnHost to, GeometryOutput out) {
  __shared__ GeometryWriter writers[kWarps];
  const std::uint32_t coplanar = out.open_count[0], others = out.open_count[1];
  const std::uint32_t units = (coplanar + kWarp - 1) / kWarp;
  const std::uint32_t all_units = units + (others + kWarp - 1) / kWarp;
  std::uint32_t unit = (blockIdx.x * kThreads + threadIdx.x) / kWarp;
  for (; unit < all_units; unit += gridDim.x * kWarps) {
    const bool front = unit < units;
    const std::uint32_t k = (front ? unit : unit - units) * kWarp + laneId();
    const bool is_there = k < (front ? coplanar : others);
    PairGeometry geometry({}, {}, {}, 0, 0);
    std::uint32_t i = 0;
    if (is_there) {
      i = out.open[front ? k : out.most - 1 - k];
      const ListedPair pair(c, ordered, out, i);
      geometry = generalGeometryOf(pair.a, pair.b, pair.separation_m);
    }
    writers[threadIdx.x / kWarp].write(out.geometry, is_there, i, geometry);
  }
  if (to.pairs == nullptr) return;
  const std::uint32_t written = orderedCount(c, ordered.room), stride = gridDim.x * kThreads;
  for (std::uint32_t i = blockIdx.x * kThreads + threadIdx.x; i < written; i += stride) {
    writeOrdered(c, ordered, to, i);
  }
}

}  // namespace

void launchGeometry(const CycleArrays& cycle, const OrderedContacts& ordered,
                    const ContactsOnHost& to, const GeometryOutput& out, unsigned blocks,
                    cudaStream_t stream) {
  if (out.most == 0) return;
  const unsigned crossing_blocks = (out.most + kThreads - 1) / kThreads;
  crossingKernel<<<crossing_blocks, kThreads, 0, stream>>>(cycle, ordered, out);
  openKernel<<<blocks, kThreads, 0, stream>>>(cycle, ordered, to, out);
  checkCuda(cudaGetLastError(), "a launch");
}

}  // namespace deformable_contact_monitor
