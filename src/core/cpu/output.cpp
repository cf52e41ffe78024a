#include "core/cpu/output.h"

#include <algorithm>

#include "core/common/parallel.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBatches = 16;  // of parts, at most: each has its own places in the buckets

// Sorts `count` contacts, whose first triangles are in one range of 2^shift, by (a, b): by a
// counting sort on a, and then the few contacts of each triangle by comparison. Once the limit is
// over, the order is unspecified. `sorted` and `begin` are scratch space.
template <class Primitive>
void sortBucket(const WorkingContact<Primitive>* contacts, std::size_t count, unsigned shift,
                const CycleLimit& limit, std::vector<WorkingContact<Primitive>>& sorted,
                std::vector<std::uint32_t>& begin) {
  const std::size_t range = std::size_t{1} << shift, mask = range - 1;
  sorted.resize(count);
  begin.assign(range + 2, 0);
  for (std::size_t i = 0; i < count; ++i) ++begin[(contacts[i].a.value & mask) + 2];
  for (std::size_t t = 2; t < range + 2; ++t) begin[t] += begin[t - 1];
  // While contacts are placed, begin[t + 1] moves from the first place of triangle t to its last.
  for (std::size_t i = 0; i < count; ++i) {
    sorted[begin[(contacts[i].a.value & mask) + 1]++] = contacts[i];
  }
  PacedLimit pace(limit, 1 << 16);
  const auto by_b = [](const auto& x, const auto& y) { return x.b < y.b; };
  for (std::size_t t = 0; t < range; ++t) {
    const std::size_t size = begin[t + 1] - begin[t];
    if (size < 2) continue;
    if (pace.over(size)) return;
    sortWithin(limit, size, by_b, [&](const auto& less) {
      std::sort(&sorted[begin[t]], &sorted[begin[t]] + size, less);
    });
  }
}

// The arrays of the result that are parallel to the contacts. The constructor makes room in them.
struct PerContactFields {
  bool separations, first_times, within_pad;

  PerContactFields(const Scene& scene, const Options& options, std::size_t count,
                   DetectionResult& result)
      : separations(listsNearPairs(scene, options)),
        first_times(options.first_times),
        within_pad(options.motion == Motion::kSwept && scene.anyPad()) {
    result.separations_m.resize(separations ? count : 0);
    result.first_times.resize(first_times ? count : 0);
    result.within_pad.resize(within_pad ? count : 0);
  }

  void write(const WorkingContact<Triangle>& contact, std::size_t i,
             DetectionResult& result) const {
    if (separations) result.separations_m[i] = contact.separation_m;
  }
  void write(const WorkingContact<MovingTriangle>& contact, std::size_t i,
             DetectionResult& result) const {
    if (first_times) result.first_times[i] = contact.first;
    if (within_pad) result.within_pad[i] = contact.within_pad ? 1 : 0;
  }
};

}  // namespace

// Fills in parts_ with the first `count` contacts.
template <class Primitive>
void ContactWriter<Primitive>::takeFirst(const ContactList<Primitive>& contacts,
                                         std::size_t count) {
  parts_.clear();
  for (const std::vector<WorkingContact<Primitive>>& block : contacts.blocks()) {
    const std::size_t taken = std::min(count, block.size());
    if (taken > 0) parts_.push_back({block.data(), taken});
    count -= taken;
  }
}

// Copies the contacts in parts_ to in_order_, bucket by bucket.
template <class Primitive>
void ContactWriter<Primitive>::intoBuckets(std::size_t triangle_count, const CycleLimit& limit) {
  constexpr std::size_t kMostBuckets = 4096;
  bucket_shift_ = 10;
  while (triangle_count >> bucket_shift_ >= kMostBuckets) ++bucket_shift_;
  const std::size_t buckets = (triangle_count >> bucket_shift_) + 1;
  const std::size_t batch_size = std::max<std::size_t>(1, blockCount(parts_.size(), kBatches));
  const std::size_t batches = blockCount(parts_.size(), batch_size);
  // Each batch counts in cache lines of its own.
  constexpr std::size_t kRound = kOwnLines / sizeof(std::uint32_t);
  const std::size_t stride = blockCount(buckets, kRound) * kRound;
  place_.assign(stride * batches + kRound, 0);
  const auto forEach = [&](const auto& visit) {
    const auto visitBatch = [&](std::size_t batch, std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end && !limit.over(); ++p) {
        const Part& part = parts_[p];
        std::uint32_t* const place = &place_[stride * batch];
        for (std::size_t i = 0; i < part.size; ++i) {
          visit(part.begin[i], place[part.begin[i].a.value >> bucket_shift_]);
        }
      }
    };
    parallelBlocks(limit, parts_.size(), batch_size, visitBatch);
  };
  forEach([](const WorkingContact<Primitive>&, std::uint32_t& count) { ++count; });
  bucket_begin_.resize(buckets + 1);
  std::uint32_t total = 0;
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    bucket_begin_[bucket] = total;
    for (std::size_t batch = 0; batch < batches; ++batch) {
      std::uint32_t& place = place_[stride * batch + bucket];
      const std::uint32_t size = place;
      place = total;
      total += size;
    }
  }
  bucket_begin_[buckets] = total;
  if (limit.wasOver()) return;
  forEach(
      [this](const WorkingContact<Primitive>& c, std::uint32_t& place) { in_order_[place++] = c; });
}

// Writes the first `count` contacts. Returns false if the limit was over before it was done.
template <class Primitive>
bool ContactWriter<Primitive>::writeFirst(const Scene& scene, const Options& options,
                                          const WorkingSet& set,
                                          const ContactList<Primitive>& contacts, std::size_t count,
                                          const CycleLimit& limit, DetectionResult& result) {
  takeFirst(contacts, count);
  resizeWithin(limit, count, in_order_);
  if (limit.wasOver()) return false;
  intoBuckets(set.size(), limit);
  if (limit.wasOver()) return false;
  const PerContactFields fields(scene, options, count, result);
  resizeWithin(limit, count, result.contacts);
  if (limit.wasOver()) return false;
  const auto writeBucket = [&](std::size_t bucket, std::size_t, std::size_t) {
    const std::size_t first = bucket_begin_[bucket], size = bucket_begin_[bucket + 1] - first;
    if (size == 0) return;
    std::vector<WorkingContact<Primitive>> sorted;
    std::vector<std::uint32_t> scratch;
    sortBucket(&in_order_[first], size, bucket_shift_, limit, sorted, scratch);
    // The order of the working set is that of (body, triangle), so that sorted indices give sorted
    // pairs.
    for (std::size_t i = 0; i < size; ++i) {
      const std::uint32_t a = sorted[i].a.value, b = sorted[i].b.value;
      result.contacts[first + i] = {set.body[a], set.triangle[a], set.body[b], set.triangle[b]};
      fields.write(sorted[i], first + i, result);
    }
  };
  parallelBlocks(limit, bucket_begin_.size() - 1, 1, writeBucket);
  return !limit.wasOver();
}

// Writes all contacts, or, if there is no time for that, only the first few.
template <class Primitive>
void ContactWriter<Primitive>::write(const Scene& scene, const Options& options,
                                     const WorkingSet& set, const ContactList<Primitive>& contacts,
                                     const CycleLimit& limit, DetectionResult& result) {
  const std::size_t found = contacts.size();
  const std::size_t few = std::min<std::size_t>(found, kMostListedLate);
  std::size_t listed = found;
  if (found == few || limit.over() ||
      !writeFirst(scene, options, set, contacts, found, limit, result)) {
    listed = few;
    writeFirst(scene, options, set, contacts, few, noLimit(), result);
  }
  result.left_out = contacts.leftOut() + found - listed;
  if (listed < found) result.cutOff(limit.why());
}

template class ContactWriter<Triangle>;
template class ContactWriter<MovingTriangle>;

}  // namespace deformable_contact_monitor
