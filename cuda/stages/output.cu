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

// Where what is sorted comes to; null: there is none.
struct SortedOutput {
  std::uint64_t* keys;
  float* separations;
  ContactTimes* times;
};

// The first `capacity` keys, with what comes with them. A null `scratch` only asks for the bytes it
// needs.
void sortKeys(const ContactArrays& contacts, std::uint32_t capacity, unsigned index_bits,
              const SortedOutput& out, void* scratch, std::size_t& scratch_bytes,
              cudaStream_t stream) {
  const auto bits = static_cast<int>(2 * index_bits);
  const std::uint64_t* const keys = contacts.contacts.data();
  cudaError_t status;
  if (out.times != nullptr) {
    status = cub::DeviceRadixSort::SortPairs(scratch, scratch_bytes, keys, out.keys,
                                             contacts.times.data(), out.times, capacity, 0, bits,
                                             stream);
  } else if (out.separations != nullptr) {
    status = cub::DeviceRadixSort::SortPairs(scratch, scratch_bytes, keys, out.keys,
                                             contacts.separations_m.data(), out.separations,
                                             capacity, 0, bits, stream);
  } else {
    status = cub::DeviceRadixSort::SortKeys(scratch, scratch_bytes, keys, out.keys, capacity, 0,
                                            bits, stream);
  }
  checkCuda(status, "cub::DeviceRadixSort");
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
  if (fields.times()) {
    sorted_times_.grow(sorted_keys_.size());
    times_.grow(sorted_keys_.size());
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
  const SortedOutput sorted{sorted_keys_.data(),
                            fields.separations ? sorted_separations_.data() : nullptr,
                            fields.times() ? sorted_times_.data() : nullptr};
  const auto sort = [&](void* scratch, std::size_t& bytes) {
    sortKeys(cycle.contacts, fetched_, index_bits, sorted, scratch, bytes, stream);
  };
  std::size_t scratch_bytes = 0;
  sort(nullptr, scratch_bytes);
  if (scratch_bytes > scratch_.size()) scratch_.grow(scratch_bytes + scratch_bytes / 2);
  sort(scratch_.data(), scratch_bytes);
  sorted_keys_.download(keys_.data(), fetched_, stream);
  if (fields.separations) sorted_separations_.download(separations_.data(), fetched_, stream);
  if (fields.times()) sorted_times_.download(times_.data(), fetched_, stream);
  if (!fields.geometry) return;
  launchGeometry(cycle, {sorted.keys, sorted.separations, fetched_, index_bits},
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
  if (fields_.times()) listTimes(count, result);
}

// What a pad alone makes a contact has a negative time.
void ContactOutput::listTimes(std::uint32_t count, DetectionResult& result) const {
  if (fields_.first_times) result.first_times.resize(count);
  if (fields_.within_pad) result.within_pad.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const ContactTimes& times = times_[i];
    const bool pad_alone = times.high < 0;
    if (fields_.first_times) result.first_times[i] = {times.low, pad_alone ? 1 : times.high};
    if (fields_.within_pad) result.within_pad[i] = pad_alone ? 1 : 0;
  }
}

void dropRepeated(DetectionResult& result) {
  const std::vector<TrianglePair> all = result.contacts;
  const auto keepFirst = [&all](auto& list) {
    if (list.empty()) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i == 0 || !(all[i] == all[i - 1])) list[kept++] = list[i];
    }
    list.resize(kept);
  };
  keepFirst(result.contacts);
  keepFirst(result.separations_m);
  keepFirst(result.geometry);
  keepFirst(result.first_times);
  keepFirst(result.within_pad);
}

}  // namespace deformable_contact_monitor
