// Stage output, on the device: writes contacts in the order of the result, and computes their
// geometry.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "core/pair_geometry.h"
#include "cuda/memory/cycle_arrays.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {

// The longest row whose order is found by counting, which takes a quadratic number of steps.
// Contacts with a longer row are sorted.
constexpr std::uint32_t kLongestRow = 2048;

// The addresses to which ordered contacts are written. Fields whose address is null are left out.
struct OrderedOutput {
  // In mapped memory of the host, with room for the first `room` contacts.
  uint4* pairs;  // TrianglePairs
  float* separations_m;
  ContactTimes* times;
  std::uint32_t room;
  std::uint32_t* too_long;  // set to 1 if some row is too long and nothing was written, else to 0
  // On the device, with the same room.
  std::uint64_t* keys;
  float* separations_on_device;
  std::uint32_t* open_count;  // set to zeros, see GeometryOutput
};

// Returns a contact in the layout of TrianglePair. `key`: as in ContactArrays::contacts.
__device__ inline uint4 pairOf(const CycleArrays& c, std::uint64_t key) {
  const ListedBody* const bodies = c.scene.listed_bodies.data();
  const unsigned bits = c.params().index_bits;
  const TriangleIndex a(static_cast<std::uint32_t>(key >> bits));
  const TriangleIndex b(static_cast<std::uint32_t>(key & ((std::uint64_t{1} << bits) - 1)));
  const ListedBody body_a = bodyOf(bodies, c.scene.body_count, a);
  const ListedBody body_b = bodyOf(bodies, c.scene.body_count, b);
  return {body_a.id, a.value - body_a.first_triangle, body_b.id, b.value - body_b.first_triangle};
}

// The kinds of contacts that do not properly cross: those that seem coplanar, and others.
constexpr unsigned kOpenKinds = 2;

// Groups the contacts by their lower triangles, in contacts.rows and row_from, and orders them. All
// calls enqueue work in the stream. `blocks`: the number of blocks of each launch.
class ContactRows {
 public:
  // Groups all contacts, in any order within a row.
  void gather(const CycleArrays& cycle, unsigned blocks, cudaStream_t stream);
  // Finds each contact's place in its row by counting, and writes it there. Call it after gather().
  // Writes nothing if some row is too long: see `too_long`.
  void write(const CycleArrays& cycle, const OrderedOutput& out, unsigned blocks,
             cudaStream_t stream) const;
  // Writes at most kLongestRow contacts in their order, without gather(). If there are more, it
  // writes nothing and sets `too_long`.
  static void writeFew(const CycleArrays& cycle, const OrderedOutput& out, unsigned blocks,
                       cudaStream_t stream);
  // Sorts the first `count` contacts of contacts.contacts and writes them, whatever their rows are.
  void sortAndWrite(const CycleArrays& cycle, std::uint32_t count, unsigned index_bits,
                    const OrderedOutput& out, unsigned blocks, cudaStream_t stream);

  std::uint64_t bytes() const { return scratch_.bytes() + places_.bytes(); }

 private:
  unsigned char* scratch(std::size_t bytes, cudaStream_t stream);

  DeviceBuffer<unsigned char> scratch_;
  DeviceBuffer<Place> places_;
};

// Sorted contacts on the device, with the keys of ContactArrays::contacts.
struct SortedContacts {
  const std::uint64_t* keys;
  const float* separations_m;  // null if all of them intersect
  std::uint32_t most;          // the number of contacts to describe, if there are so many
};

// Where sorted contacts and their geometry are written, in their order.
struct GeometryOutput {
  // In mapped memory of the host: `room` TrianglePairs, and the geometry of SortedContacts::most.
  uint4* pairs;
  std::uint32_t room;
  PairGeometry* geometry;
  // On the device: the places of contacts that do not properly cross. Those that seem coplanar are
  // listed from the front, others from the back. There is room for SortedContacts::most.
  std::uint32_t* open;
  std::uint32_t* open_count;  // kOpenKinds numbers: how many are listed of either kind; zero before
};

// Enqueues the computation of each contact's geometry, and writes the contacts too: the bus is
// idle while the last of the geometry is computed. Reads scene.corners and scene.posed. `blocks`:
// the number of blocks of the launch for contacts that do not properly cross.
void launchGeometry(const CycleArrays& cycle, const SortedContacts& sorted,
                    const GeometryOutput& out, unsigned blocks, cudaStream_t stream);

}  // namespace deformable_contact_monitor
