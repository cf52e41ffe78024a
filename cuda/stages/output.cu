#include <algorithm>
#include <cub/device/device_radix_sort.cuh>
#include <vector>

#include "cuda/stages/geometry.cuh"
#include "cuda/stages/output.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256;

// A thread for each place of contacts.contacts behind the last contact, up to `capacity`: fills it
// with a key that sorts behind all contacts, for a sort of fixed size.
__global__ void __launch_bounds__(kThreads) padKernel(CycleArrays c, std::uint32_t capacity) {
  const std::uint64_t count = c.counters().contacts;
  const std::uint64_t i = count + blockIdx.x * kThreads + threadIdx.x;
  if (i >= count && i < capacity) {
    c.contacts.contacts[Place(static_cast<std::uint32_t>(i))] = kNoContact;
  }
}

// The first `capacity` keys, with their separations if `separations_out` is not null. A null
// `scratch` only asks for the bytes it needs.
void sortKeys(const ContactArrays& contacts, std::uint32_t capacity, unsigned index_bits,
              std::uint64_t* keys_out, float* separations_out, void* scratch,
              std::size_t& scratch_bytes, cudaStream_t stream) {
  const auto bits = static_cast<int>(2 * index_bits);
  checkCuda(separations_out != nullptr
                ? cub::DeviceRadixSort::SortPairs(scratch, scratch_bytes, contacts.contacts.data(),
                                                  keys_out, contacts.separations_m.data(),
                                                  separations_out, capacity, 0, bits, stream)
                : cub::DeviceRadixSort::SortKeys(scratch, scratch_bytes, contacts.contacts.data(),
                                                 keys_out, capacity, 0, bits, stream),
            "cub::DeviceRadixSort");
}

}  // namespace

void ContactOutput::makeRoom(std::uint32_t count, std::uint32_t most, const ContactFields& fields) {
  if (count > sorted_keys_.size()) {
    // With room to spare, or contacts that creep up would allocate in every cycle.
    sorted_keys_.grow(std::min(most, count + count / 2));
  }
  keys_.grow(sorted_keys_.size());
  if (fields.separations) {
    sorted_separations_.grow(sorted_keys_.size());
    separations_.grow(sorted_keys_.size());
  }
  if (fields.geometry) {
    geometry_on_device_.grow(sorted_keys_.size());
    geometry_.grow(sorted_keys_.size());
  }
}

void ContactOutput::fetch(const CycleArrays& cycle, const ContactFields& fields,
                          unsigned index_bits, std::uint32_t count, cudaStream_t stream) {
  const std::uint32_t most = cycle.contacts.contacts.size();
  fetched_ = std::min(most, count + count / 4 + 1024);
  index_bits_ = index_bits;
  fields_ = fields;
  makeRoom(fetched_, most, fields);
  padKernel<<<(fetched_ + kThreads - 1) / kThreads, kThreads, 0, stream>>>(cycle, fetched_);
  float* const separations_out = fields.separations ? sorted_separations_.data() : nullptr;
  const auto sort = [&](void* scratch, std::size_t& bytes) {
    sortKeys(cycle.contacts, fetched_, index_bits, sorted_keys_.data(), separations_out, scratch,
             bytes, stream);
  };
  std::size_t scratch_bytes = 0;
  sort(nullptr, scratch_bytes);
  if (scratch_bytes > scratch_.size()) scratch_.grow(scratch_bytes + scratch_bytes / 2);
  sort(scratch_.data(), scratch_bytes);
  sorted_keys_.download(keys_.data(), fetched_, stream);
  if (fields.separations) sorted_separations_.download(separations_.data(), fetched_, stream);
  if (!fields.geometry) return;
  launchGeometry(cycle, {sorted_keys_.data(), separations_out, fetched_, index_bits},
                 geometry_on_device_.data(), stream);
  geometry_on_device_.download(geometry_.data(), fetched_, stream);
}

void ContactOutput::list(const DeviceScene& scene, std::uint32_t count, const CycleLimit& limit,
                         DetectionResult& result) const {
  constexpr std::uint32_t kBlock = 1 << 16;
  const std::uint64_t mask = (std::uint64_t{1} << index_bits_) - 1;
  result.contacts.resize(count);
  std::uint32_t done = 0;
  while (done < count && (done < kMostListedLate || !limit.over())) {
    // Nothing but the list within: it is the longest part of the way back.
    const std::uint32_t end = std::min(count, std::max(kMostListedLate, done + kBlock));
    for (std::uint32_t i = done; i < end; ++i) {
      const TriangleIndex a(static_cast<std::uint32_t>(keys_[i] >> index_bits_));
      const TriangleIndex b(static_cast<std::uint32_t>(keys_[i] & mask));
      result.contacts[i] = {scene.bodyOf(a), scene.localOf(a), scene.bodyOf(b), scene.localOf(b)};
    }
    done = end;
  }
  count = done;
  result.contacts.resize(count);
  if (fields_.separations) {
    result.separations_m.assign(separations_.data(), separations_.data() + count);
  }
  if (fields_.geometry) result.geometry.assign(geometry_.data(), geometry_.data() + count);
}

void dropRepeated(DetectionResult& result) {
  std::vector<TrianglePair>& contacts = result.contacts;
  std::vector<float>& separations_m = result.separations_m;
  std::vector<PairGeometry>& geometry = result.geometry;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (kept > 0 && contacts[i] == contacts[kept - 1]) continue;
    contacts[kept] = contacts[i];
    if (!separations_m.empty()) separations_m[kept] = separations_m[i];
    if (!geometry.empty()) geometry[kept] = geometry[i];
    ++kept;
  }
  contacts.resize(kept);
  if (!separations_m.empty()) separations_m.resize(kept);
  if (!geometry.empty()) geometry.resize(kept);
}

}  // namespace deformable_contact_monitor
