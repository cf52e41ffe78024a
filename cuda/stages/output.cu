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
void ContactOutput::makeRoom(std::uint32_t count, DetectionResult& result, cudaStream_t stream) {
  constexpr std::size_t kMost = std::numeric_limits<std::uint32_t>::max();
  TrianglePairs& contacts = result.contacts;
  if (count > contacts.capacity()) {
    contacts.clear();
    contacts.reserve(count + std::size_t{count} / 4);
  }
  contacts.resize(std::min(contacts.capacity(), kMost));
  room_ = static_cast<std::uint32_t>(result.contacts.size());
  if (fields_.separations) separations_.grow(room_);
  if (fields_.times()) times_.grow(room_);
  if (!fields_.geometry) return;
  if (room_ > result.geometry.capacity()) {
    result.geometry.clear();
    result.geometry.reserve(room_);
  }
  result.geometry.resize(room_);
  keys_.grow(room_, stream);
  open_.grow(room_, stream);
  open_count_.grow(kOpenKinds, stream);
  if (fields_.separations) sorted_separations_.grow(room_, stream);
}

OrderedOutput ContactOutput::output(DetectionResult& result) {
  OrderedOutput out{};
  if (!fields_.geometry) out.pairs = reinterpret_cast<uint4*>(result.contacts.data());
  if (fields_.separations) out.separations_m = separations_.data();
  if (fields_.times()) out.times = times_.data();
  out.room = room_;
  out.too_long = too_long_.data();
  if (fields_.geometry) {
    out.keys = keys_.data();
    out.open_count = open_count_.data();
  }
  if (fields_.geometry && fields_.separations) {
    out.separations_on_device = sorted_separations_.data();
  }
  return out;
}

void ContactOutput::fetch(const CycleArrays& cycle, const ContactFields& fields,
                          std::uint32_t expected, std::uint32_t most_described,
                          DetectionResult& result, cudaStream_t stream) {
  fields_ = fields;
  makeRoom(expected, result, stream);
  gathered_ = expected > kLongestRow / 2;
  if (gathered_) rows_.gather(cycle, blocks_, stream);
  write(cycle, result, stream);
  describe(cycle, most_described, result, stream);
}

void ContactOutput::fetchAgain(const CycleArrays& cycle, unsigned index_bits, std::uint32_t count,
                               DetectionResult& result, cudaStream_t stream) {
  makeRoom(count, result, stream);
  if (too_long_[0] != 0) {
    rows_.sortAndWrite(cycle, count, index_bits, output(result), blocks_, stream);
    too_long_[0] = 0;
    room_ = count;
  } else {
    write(cycle, result, stream);
  }
  describe(cycle, count, result, stream);
}

void ContactOutput::write(const CycleArrays& cycle, DetectionResult& result, cudaStream_t stream) {
  if (gathered_) {
    rows_.write(cycle, output(result), blocks_, stream);
  } else {
    ContactRows::writeFew(cycle, output(result), blocks_, stream);
  }
}

// Writes the contacts, and computes the geometry of the first `most`.
void ContactOutput::describe(const CycleArrays& cycle, std::uint32_t most, DetectionResult& result,
                             cudaStream_t stream) {
  described_ = 0;
  if (!fields_.geometry) return;
  described_ = std::min(most, room_);
  launchGeometry(
      cycle, {keys_.data(), fields_.separations ? sorted_separations_.data() : nullptr, described_},
      {reinterpret_cast<uint4*>(result.contacts.data()), room_, result.geometry.data(),
       open_.data(), open_count_.data()},
      blocks_, stream);
}

void ContactOutput::list(std::uint32_t count, DetectionResult& result) const {
  count = std::min(count, room_);
  result.contacts.resize(count);
  if (fields_.separations) {
    result.separations_m.assign(separations_.data(), separations_.data() + count);
  }
  result.geometry.resize(fields_.geometry && count <= described_ ? count : 0);
  if (fields_.times()) listTimes(count, result);
}

// Copies times and flags. A contact that only a pad makes has a negative `high`.
void ContactOutput::listTimes(std::uint32_t count, DetectionResult& result) const {
  const ContactTimes* const times = times_.data();
  if (fields_.first_times) {
    result.first_times.resize(count);
    FirstContact* const first = result.first_times.data();
    for (std::uint32_t i = 0; i < count; ++i) {
      first[i] = {times[i].low, times[i].high < 0 ? 1 : times[i].high};
    }
  }
  if (fields_.within_pad) {
    result.within_pad.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) result.within_pad[i] = times[i].high < 0 ? 1 : 0;
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
