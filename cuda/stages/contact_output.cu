#include <algorithm>

#include "cuda/stages/contact_output.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {

void ContactOutput::fetch(const CycleView& cycle, bool separations, unsigned index_bits,
                          std::uint32_t count, cudaStream_t stream) {
  const std::uint32_t capacity = std::min(cycle.contact_capacity, count + count / 4 + 1024);
  if (capacity > sorted_keys_.size()) {
    // With room to spare, or contacts that creep up would allocate in every cycle.
    sorted_keys_.grow(std::min(cycle.contact_capacity, capacity + capacity / 2));
  }
  keys_.grow(sorted_keys_.size());
  if (separations) {
    sorted_separations_.grow(sorted_keys_.size());
    separations_.grow(sorted_keys_.size());
  }
  float* const separations_out = separations ? sorted_separations_.data() : nullptr;
  std::size_t scratch_bytes = 0;
  sortContacts(cycle, capacity, index_bits, sorted_keys_.data(), separations_out, nullptr,
               scratch_bytes, stream);
  if (scratch_bytes > scratch_.size()) scratch_.grow(scratch_bytes + scratch_bytes / 2);
  sortContacts(cycle, capacity, index_bits, sorted_keys_.data(), separations_out, scratch_.data(),
               scratch_bytes, stream);
  sorted_keys_.download(keys_.data(), capacity, stream);
  if (separations) sorted_separations_.download(separations_.data(), capacity, stream);
  fetched_ = capacity;
  index_bits_ = index_bits;
  with_separations_ = separations;
}

void ContactOutput::list(const DeviceScene& scene, std::uint32_t count,
                         DetectionResult& result) const {
  const std::uint64_t mask = (std::uint64_t{1} << index_bits_) - 1;
  result.contacts.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto a = static_cast<std::uint32_t>(keys_[i] >> index_bits_);
    const auto b = static_cast<std::uint32_t>(keys_[i] & mask);
    result.contacts[i] = {scene.bodyOf(a), scene.localOf(a), scene.bodyOf(b), scene.localOf(b)};
  }
  if (with_separations_) {
    result.separations_m.assign(separations_.data(), separations_.data() + count);
  } else {
    result.separations_m.clear();
  }
}

}  // namespace deformable_contact_monitor
