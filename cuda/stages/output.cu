// Brings sorted contacts to the host. The device writes them directly into page-locked memory, so
// the transfer can be enqueued before the host knows their number.
#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "cuda/stages/output.cuh"
#include "cuda/stages/rows.cuh"

namespace deformable_contact_monitor {

// Allocates more than is needed, because a slowly growing number of contacts would otherwise
// allocate in every cycle.
void ContactOutput::makeRoom(std::uint32_t count, TrianglePairs& contacts, cudaStream_t stream) {
  constexpr std::size_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (count > contacts.capacity()) {
    contacts.clear();
    contacts.reserve(count + std::size_t{count} / 4);
  }
  contacts.resize(std::min(contacts.capacity(), kMost));
  room_ = static_cast<std::uint32_t>(contacts.size());
  if (fields_.separations) separations_.grow(room_);
  if (fields_.times()) times_.grow(room_);
  if (!fields_.geometry) return;
  geometry_.grow(room_);
  if (geometry_on_device_.grow(room_, stream)) {
    // Clears the array, because fetches may copy more elements than there are contacts.
    checkCuda(cudaMemsetAsync(geometry_on_device_.data(), 0, geometry_on_device_.bytes(), stream),
              "cudaMemsetAsync");
  }
  keys_.grow(room_, stream);
  if (fields_.separations) sorted_separations_.grow(room_, stream);
}

OrderedOutput ContactOutput::output(TrianglePairs& contacts) {
  OrderedOutput out{};
  out.pairs = reinterpret_cast<uint4*>(contacts.data());
  if (fields_.separations) out.separations_m = separations_.data();
  if (fields_.times()) out.times = times_.data();
  out.room = room_;
  out.too_long = too_long_.data();
  if (fields_.geometry) out.keys = keys_.data();
  if (fields_.geometry && fields_.separations) {
    out.separations_on_device = sorted_separations_.data();
  }
  return out;
}

void ContactOutput::fetch(const CycleArrays& cycle, const ContactFields& fields,
                          std::uint32_t expected, std::uint32_t most_described,
                          TrianglePairs& contacts, cudaStream_t stream) {
  fields_ = fields;
  makeRoom(expected, contacts, stream);
  gathered_ = expected > kLongestRow / 2;
  if (gathered_) rows_.gather(cycle, blocks_, stream);
  write(cycle, contacts, stream);
  describe(cycle, std::min(most_described, expected + expected / 4 + 1024), stream);
}

void ContactOutput::fetchAgain(const CycleArrays& cycle, unsigned index_bits, std::uint32_t count,
                               TrianglePairs& contacts, cudaStream_t stream) {
  makeRoom(count, contacts, stream);
  if (too_long_[0] != 0) {
    rows_.sortAndWrite(cycle, count, index_bits, output(contacts), blocks_, stream);
    too_long_[0] = 0;
    room_ = count;
  } else {
    write(cycle, contacts, stream);
  }
  describe(cycle, count, stream);
}

void ContactOutput::write(const CycleArrays& cycle, TrianglePairs& contacts, cudaStream_t stream) {
  if (gathered_) {
    rows_.write(cycle, output(contacts), blocks_, stream);
  } else {
    ContactRows::writeFew(cycle, output(contacts), blocks_, stream);
  }
}

// Computes the geometry of the first `most` contacts and fetches it.
void ContactOutput::describe(const CycleArrays& cycle, std::uint32_t most, cudaStream_t stream) {
  described_ = 0;
  if (!fields_.geometry) return;
  described_ = std::min(most, room_);
  launchGeometry(
      cycle, {keys_.data(), fields_.separations ? sorted_separations_.data() : nullptr, described_},
      geometry_on_device_.data(), stream);
  geometry_on_device_.download(geometry_.data(), described_, stream);
}

void ContactOutput::list(std::uint32_t count, DetectionResult& result) const {
  count = std::min(count, room_);
  result.contacts.resize(count);
  if (fields_.separations) {
    result.separations_m.assign(separations_.data(), separations_.data() + count);
  }
  if (fields_.geometry && count <= described_) {
    result.geometry.assign(geometry_.data(), geometry_.data() + count);
  }
  if (fields_.times()) listTimes(count, result);
}

// Copies times and flags. A contact that only a pad makes has a negative `high`.
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
