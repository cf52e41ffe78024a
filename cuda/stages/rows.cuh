// Stage output: contacts in the order of the result, on the device.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {

// Counting takes each of a row's contacts as many steps as there are: longer ones are sorted.
constexpr std::uint32_t kLongestRow = 2048;

// Where contacts are written to in their order; what is null is left out.
struct OrderedOutput {
  // In mapped memory of the host, for the first `room` contacts.
  uint4* pairs;  // TrianglePairs
  float* separations_m;
  ContactTimes* times;
  std::uint32_t room;
  std::uint32_t* too_long;  // becomes 1, and nothing is written, where some row is; else 0
  // On the device, for as many.
  std::uint64_t* keys;
  float* separations_on_device;
};

// The contacts by their lower triangles, in contacts.rows and row_from. All behind what is in the
// stream; `blocks`: of the launches.
class ContactRows {
 public:
  // Of all contacts, in any order within a row.
  void gather(const CycleArrays& cycle, unsigned blocks, cudaStream_t stream);
  // Behind gather(): finds each contact's place in its row by counting, and writes it there. Rows
  // that are too long for that are left: see `too_long`.
  void write(const CycleArrays& cycle, const OrderedOutput& out, unsigned blocks,
             cudaStream_t stream) const;
  // Of contacts that are as few as in a row: writes them without gather(); more of them are too
  // long.
  static void writeFew(const CycleArrays& cycle, const OrderedOutput& out, unsigned blocks,
                       cudaStream_t stream);
  // For any rows: sorts the first `count` contacts of contacts.contacts, and writes them.
  void sortAndWrite(const CycleArrays& cycle, std::uint32_t count, unsigned index_bits,
                    const OrderedOutput& out, unsigned blocks, cudaStream_t stream);

  std::uint64_t bytes() const { return scratch_.bytes() + places_.bytes(); }

 private:
  unsigned char* scratch(std::size_t bytes, cudaStream_t stream);

  DeviceBuffer<unsigned char> scratch_;
  DeviceBuffer<Place> places_;
};

}  // namespace deformable_contact_monitor
