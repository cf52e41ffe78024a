// Stage output, on the device: brings contacts into the order of the result, computes their
// geometry, and writes both to the host.
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

// The contacts of a cycle in the order of the result, on the device.
struct OrderedContacts {
  std::uint64_t* keys;  // as in ContactArrays::contacts
  // The place at which each was found, where its times and its separation are. Null if neither is
  // wanted.
  Place* from;
  std::uint32_t room;  // only the first so many are kept
};

// Where ordered contacts are written, in mapped memory of the host with the same room. Fields whose
// address is null are left out.
struct ContactsOnHost {
  uint4* pairs;  // TrianglePairs
  float* separations_m;
  ContactTimes* times;
};

// What is set before contacts are ordered.
struct OrderStatus {
  std::uint32_t* too_long;  // on the host: 1 if some row is too long and nothing is ordered, else 0
  std::uint32_t* open_count;  // set to zeros, see GeometryOutput; may be null
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

// Returns how many ordered contacts there are on the device.
__device__ inline std::uint32_t orderedCount(const CycleArrays& c, std::uint32_t room) {
  if (c.contacts.row_too_long[Place(0)] != 0) return 0;
  return min(room, c.listedContacts());
}

// Writes an ordered contact to its place on the host.
__device__ inline void writeOrdered(const CycleArrays& c, const OrderedContacts& ordered,
                                    const ContactsOnHost& to, std::uint32_t i) {
  if (to.pairs != nullptr) to.pairs[i] = pairOf(c, ordered.keys[i]);
  if (to.times != nullptr) to.times[i] = c.contacts.times[ordered.from[i]];
  if (to.separations_m != nullptr) {
    to.separations_m[i] = c.contacts.separations_m[ordered.from[i]];
  }
}

// Orders contacts by their rows, a row being all contacts of one lower triangle, and writes them to
// the host. All calls enqueue work in the stream. `blocks`: the number of blocks of each launch.
class ContactRows {
 public:
  // Groups all contacts into contacts.rows and row_from, in any order within a row.
  void gather(const CycleArrays& cycle, unsigned blocks, cudaStream_t stream);
  // Finds each contact's place in its row by counting. Call it after gather(). `ordered` must not
  // be in contacts.rows. Orders nothing if some row is too long: see OrderStatus.
  static void order(const CycleArrays& cycle, const OrderedContacts& ordered,
                    const OrderStatus& status, unsigned blocks, cudaStream_t stream);
  // Writes ordered contacts to the host in their order: single ones would be slow over the bus.
  static void write(const CycleArrays& cycle, const OrderedContacts& ordered,
                    const ContactsOnHost& to, unsigned blocks, cudaStream_t stream);
  // Does the work of all three for at most kLongestRow contacts. If there are more, it writes
  // nothing and says that a row is too long. `ordered` must not be in contacts.contacts.
  static void writeFew(const CycleArrays& cycle, const OrderedContacts& ordered,
                       const ContactsOnHost& to, const OrderStatus& status, unsigned blocks,
                       cudaStream_t stream);
  // Sorts the first `count` contacts of contacts.contacts, whatever their rows are, into
  // contacts.rows and row_from.
  void sort(const CycleArrays& cycle, std::uint32_t count, unsigned index_bits,
            const OrderStatus& status, unsigned blocks, cudaStream_t stream);

  std::uint64_t bytes() const { return scratch_.bytes() + places_.bytes(); }

 private:
  unsigned char* scratch(std::size_t bytes, cudaStream_t stream);

  DeviceBuffer<unsigned char> scratch_;
  DeviceBuffer<Place> places_;
};

// Where the geometry of ordered contacts is written, each at its contact's place.
struct GeometryOutput {
  PairGeometry* geometry;      // in mapped memory of the host
  std::uint32_t most;          // the number of contacts to describe, if there are so many
  const float* separations_m;  // ContactArrays::separations_m; null if all contacts intersect
  // On the device: the places of contacts that do not properly cross. Those that seem coplanar are
  // listed from the front, others from the back. There is room for `most`.
  std::uint32_t* open;
  std::uint32_t* open_count;  // kOpenKinds numbers: how many are listed of either kind; zero before
};

// Enqueues the computation of the contacts' geometry, and writes the contacts too: few threads
// describe those that do not properly cross, and the bus would be idle meanwhile. Reads
// scene.corners and scene.posed. `blocks`: the number of blocks of the launch for contacts that do
// not properly cross.
void launchGeometry(const CycleArrays& cycle, const OrderedContacts& ordered,
                    const ContactsOnHost& to, const GeometryOutput& out, unsigned blocks,
                    cudaStream_t stream);

}  // namespace deformable_contact_monitor
