// Stage output: orders the contacts. Contacts with the same lower triangle form a row. A prefix sum
// of the rows' lengths tells where each row begins. A triangle meets few others, so counting the
// lesser keys of its row finds a contact's place faster than a sort does. If a row is too long for
// that, all contacts are sorted.
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "cuda/device/warp.cuh"
#include "cuda/stages/rows.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;

__device__ TriangleIndex lowerOf(const CycleArrays& c, std::uint64_t key) {
  return TriangleIndex(static_cast<std::uint32_t>(key >> c.params().index_bits));
}

// One thread for each contact: counts the contacts of each row.
__global__ void __launch_bounds__(kThreads) countKernel(CycleArrays c) {
  const std::uint32_t count = c.listedContacts(), stride = gridDim.x * kThreads;
  std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  if (i == 0) c.contacts.row_too_long[Place(0)] = 0;
  for (; i < count; i += stride) {
    atomicAdd(&c.contacts.row_count[lowerOf(c, c.contacts.contacts[Place(i)])], 1U);
  }
}

// One thread for each contact: puts it into its row, in any order. Counts the rows down again, so
// that the next cycle finds zeros.
__global__ void __launch_bounds__(kThreads) scatterKernel(CycleArrays c) {
  const std::uint32_t count = c.listedContacts(), stride = gridDim.x * kThreads;
  for (std::uint32_t i = blockIdx.x * kThreads + threadIdx.x; i < count; i += stride) {
    const std::uint64_t key = c.contacts.contacts[Place(i)];
    const TriangleIndex a = lowerOf(c, key);
    const std::uint32_t left = atomicSub(&c.contacts.row_count[a], 1U);
    if (left > kLongestRow) c.contacts.row_too_long[Place(0)] = 1;
    const Place place = c.contacts.row_begin[a] + (left - 1);
    c.contacts.rows[place] = key;
    c.contacts.row_from[place] = Place(i);
  }
}

// Puts a contact to its place in the order. `from`: the place at which it was found.
__device__ void put(const OrderedContacts& ordered, std::uint32_t place, std::uint64_t key,
                    Place from) {
  if (place >= ordered.room) return;
  ordered.keys[place] = key;
  if (ordered.from != nullptr) ordered.from[place] = from;
}

// Called by one thread before contacts are ordered, or not ordered because of long rows.
__device__ void begin(const OrderStatus& status, bool too_long) {
  *status.too_long = too_long ? 1 : 0;
  if (status.open_count == nullptr) return;
  for (unsigned k = 0; k < kOpenKinds; ++k) status.open_count[k] = 0;
}

// One thread for each contact: finds its place in its row by counting the lesser keys. A contact
// that was found twice gets two places.
__global__ void __launch_bounds__(kThreads)
    orderKernel(CycleArrays c, OrderedContacts ordered, OrderStatus status) {
  const bool too_long = c.contacts.row_too_long[Place(0)] != 0;
  const std::uint32_t count = c.listedContacts(), stride = gridDim.x * kThreads;
  std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  if (i == 0) begin(status, too_long);
  if (too_long) return;
  for (; i < count; i += stride) {
    const std::uint64_t key = c.contacts.rows[Place(i)];
    const TriangleIndex a = lowerOf(c, key);
    const std::uint32_t first = c.contacts.row_begin[a].value;
    const std::uint32_t end = c.contacts.row_begin[a + 1].value;
    std::uint32_t place = first;
    for (std::uint32_t k = first; k < end; ++k) {
      const std::uint64_t other = c.contacts.rows[Place(k)];
      place += other < key || (other == key && k < i) ? 1 : 0;
    }
    put(ordered, place, key, c.contacts.row_from[Place(i)]);
  }
}

// One thread for each ordered contact.
__global__ void __launch_bounds__(kThreads)
    writeKernel(CycleArrays c, OrderedContacts ordered, ContactsOnHost to) {
  const std::uint32_t count = orderedCount(c, ordered.room), stride = gridDim.x * kThreads;
  for (std::uint32_t i = blockIdx.x * kThreads + threadIdx.x; i < count; i += stride) {
    writeOrdered(c, ordered, to, i);
  }
}

// One warp for each contact: orders few contacts as if all of them were one row, and writes them.
__global__ void __launch_bounds__(kThreads)
    writeFewKernel(CycleArrays c, OrderedContacts ordered, ContactsOnHost to, OrderStatus status) {
  const std::uint32_t count = c.listedContacts(), stride = gridDim.x * kThreads / kWarp;
  const bool too_long = count > kLongestRow;
  if (blockIdx.x == 0 && threadIdx.x == 0) {
    c.contacts.row_too_long[Place(0)] = too_long ? 1 : 0;
    begin(status, too_long);
  }
  if (too_long) return;
  for (std::uint32_t i = (blockIdx.x * kThreads + threadIdx.x) / kWarp; i < count; i += stride) {
    const std::uint64_t key = c.contacts.contacts[Place(i)];
    std::uint32_t before = 0;
    for (std::uint32_t k = laneId(); k < count; k += kWarp) {
      const std::uint64_t other = c.contacts.contacts[Place(k)];
      before += other < key || (other == key && k < i) ? 1 : 0;
    }
    before = warpSum(before);
    if (laneId() != 0 || before >= ordered.room) continue;
    put(ordered, before, key, Place(i));
    writeOrdered(c, ordered, to, before);
  }
}

// Numbers the contacts before the sort, to find their times and separations afterwards.
__global__ void __launch_bounds__(kThreads)
    numberKernel(CycleArrays c, OrderStatus status, Place* places, std::uint32_t count) {
  const std::uint32_t stride = gridDim.x * kThreads;
  std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  if (i == 0) {
    c.contacts.row_too_long[Place(0)] = 0;
    begin(status, false);
  }
  for (; i < count; i += stride) places[i] = Place(i);
}

}  // namespace

unsigned char* ContactRows::scratch(std::size_t bytes, cudaStream_t stream) {
  if (bytes > scratch_.size()) scratch_.grow(bytes + bytes / 2, stream);
  return scratch_.data();
}

void ContactRows::gather(const CycleArrays& cycle, unsigned blocks, cudaStream_t stream) {
  countKernel<<<blocks, kThreads, 0, stream>>>(cycle);
  const auto scan = [&](void* memory, std::size_t& bytes) {
    checkCuda(cub::DeviceScan::ExclusiveSum(
                  memory, bytes, cycle.contacts.row_count.data(),
                  reinterpret_cast<std::uint32_t*>(cycle.contacts.row_begin.data()),
                  cycle.scene.triangle_count + 1, stream),
              "cub::DeviceScan");
  };
  std::size_t bytes = 0;
  scan(nullptr, bytes);
  scan(scratch(bytes, stream), bytes);
  scatterKernel<<<blocks, kThreads, 0, stream>>>(cycle);
}

void ContactRows::order(const CycleArrays& cycle, const OrderedContacts& ordered,
                        const OrderStatus& status, unsigned blocks, cudaStream_t stream) {
  orderKernel<<<blocks, kThreads, 0, stream>>>(cycle, ordered, status);
}

void ContactRows::write(const CycleArrays& cycle, const OrderedContacts& ordered,
                        const ContactsOnHost& to, unsigned blocks, cudaStream_t stream) {
  writeKernel<<<blocks, kThreads, 0, stream>>>(cycle, ordered, to);
}

void ContactRows::writeFew(const CycleArrays& cycle, const OrderedContacts& ordered,
                           const ContactsOnHost& to, const OrderStatus& status, unsigned blocks,
                           cudaStream_t stream) {
  writeFewKernel<<<blocks, kThreads, 0, stream>>>(cycle, ordered, to, status);
}

void ContactRows::sort(const CycleArrays& cycle, std::uint32_t count, unsigned index_bits,
                       const OrderStatus& status, unsigned blocks, cudaStream_t stream) {
  places_.grow(count, stream);
  numberKernel<<<blocks, kThreads, 0, stream>>>(cycle, status, places_.data(), count);
  const auto sort = [&](void* memory, std::size_t& bytes) {
    checkCuda(cub::DeviceRadixSort::SortPairs(memory, bytes, cycle.contacts.contacts.data(),
                                              cycle.contacts.rows.data(), places_.data(),
                                              cycle.contacts.row_from.data(), count, 0,
                                              static_cast<int>(2 * index_bits), stream),
              "cub::DeviceRadixSort");
  };
  std::size_t bytes = 0;
  sort(nullptr, bytes);
  sort(scratch(bytes, stream), bytes);
}

}  // namespace deformable_contact_monitor
