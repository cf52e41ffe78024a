// Brings ordered contacts to the host. The device writes them directly into page-locked memory, so
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
  if (fields_.ofContacts()) from_.grow(room_, stream);
  if (!fields_.geometry) return;
  if (room_ > result.geometry.capacity()) {
    result.geometry.clear();
    result.geometry.reserve(room_);
  }
  result.geometry.resize(room_);
  open_.grow(room_, stream);
  open_count_.grow(kOpenKinds, stream);
}

OrderStatus ContactOutput::status() {
  return {too_long_.data(), fields_.geometry ? open_count_.data() : nullptr};
}

ContactsOnHost ContactOutput::onHost(DetectionResult& result) {
  return {reinterpret_cast<uint4*>(result.contacts.data()),
          fields_.separations ? separations_.data() : nullptr,
          fields_.times() ? times_.data() : nullptr};
}

void ContactOutput::fetch(const CycleArrays& cycle, const ContactFields& fields,
                          std::uint32_t expected, std::uint32_t most_described,
                          DetectionResult& result, cudaStream_t stream) {
  fields_ = fields;
  makeRoom(expected, result, stream);
  gathered_ = expected > kLongestRow / 2;
  if (gathered_) rows_.gather(cycle, blocks_, stream);
  orderAndWrite(cycle, most_described, result, stream);
}

void ContactOutput::fetchAgain(const CycleArrays& cycle, unsigned index_bits, std::uint32_t count,
                               DetectionResult& result, cudaStream_t stream) {
  makeRoom(count, result, stream);
  if (too_long_[0] == 0) return orderAndWrite(cycle, count, result, stream);
  room_ = count;
  rows_.sort(cycle, count, index_bits, status(), blocks_, stream);
  describeAndWrite(cycle, {cycle.contacts.rows.data(), cycle.contacts.row_from.data(), room_},
                   onHost(result), count, result, stream);
}

// Rows are ordered into the memory of the contacts as they were found, which are not needed again.
void ContactOutput::orderAndWrite(const CycleArrays& cycle, std::uint32_t most_described,
                                  DetectionResult& result, cudaStream_t stream) {
  const ContactArrays& arrays = cycle.contacts;
  if (gathered_) {
    const OrderedContacts ordered{arrays.contacts.data(),
                                  fields_.ofContacts() ? from_.data() : nullptr, room_};
    ContactRows::order(cycle, ordered, status(), blocks_, stream);
    describeAndWrite(cycle, ordered, onHost(result), most_described, result, stream);
  } else {
    const OrderedContacts ordered{arrays.rows.data(), arrays.row_from.data(), room_};
    ContactRows::writeFew(cycle, ordered, onHost(result), status(), blocks_, stream);
    describeAndWrite(cycle, ordered, {}, most_described, result, stream);
  }
}

// Computes the geometry of the first `most_described` contacts, and writes all to `to`, whose
// fields are null if that was done.
void ContactOutput::describeAndWrite(const CycleArrays& cycle, const OrderedContacts& ordered,
                                     const ContactsOnHost& to, std::uint32_t most_described,
                                     DetectionResult& result, cudaStream_t stream) {
  described_ = fields_.geometry ? std::min(most_described, room_) : 0;
  if (described_ > 0) {
    const float* const separations_m =
        fields_.separations ? cycle.contacts.separations_m.data() : nullptr;
    launchGeometry(
        cycle, ordered, to,
        {result.geometry.data(), described_, separations_m, open_.data(), open_count_.data()},
        blocks_, stream);
  } else if (to.pairs != nullptr) {
    ContactRows::write(cycle, ordered, to, blocks_, stream);
  }
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
