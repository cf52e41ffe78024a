// The list of contacts in ascending order.
#include <cub/device/device_radix_sort.cuh>

#include "cuda/memory/device_buffer.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;

// Keys that sort behind all contacts, for a sort of fixed size.
__global__ void __launch_bounds__(kThreads) padKernel(CycleView c, std::uint32_t capacity) {
  const std::uint64_t count = c.counters->contacts;
  const std::uint64_t i = count + blockIdx.x * kThreads + threadIdx.x;
  if (i >= count && i < capacity) c.contacts[i] = ~std::uint64_t{0};
}

}  // namespace

void sortContacts(const CycleView& cycle, std::uint32_t capacity, unsigned index_bits,
                  std::uint64_t* keys_out, float* separations_out, void* scratch,
                  std::size_t& scratch_bytes, cudaStream_t stream) {
  if (scratch != nullptr) {
    padKernel<<<(capacity + kThreads - 1) / kThreads, kThreads, 0, stream>>>(cycle, capacity);
  }
  const auto bits = static_cast<int>(2 * index_bits);
  checkCuda(separations_out != nullptr
                ? cub::DeviceRadixSort::SortPairs(scratch, scratch_bytes, cycle.contacts, keys_out,
                                                  cycle.separations_m, separations_out, capacity, 0,
                                                  bits, stream)
                : cub::DeviceRadixSort::SortKeys(scratch, scratch_bytes, cycle.contacts, keys_out,
                                                 capacity, 0, bits, stream),
            "cub::DeviceRadixSort");
}

}  // namespace deformable_contact_monitor
