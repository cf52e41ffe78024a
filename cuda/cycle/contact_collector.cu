// Fetches contacts in two steps. The first fetch is enqueued before the number of contacts is
// known, with room for as many as the last cycle had; complete() fetches what is missing.
#include <algorithm>
#include <limits>

#include "core/common/parallel.h"
#include "core/common/stopwatch.h"
#include "core/predicates/swept_exact.h"
#include "core/predicates/swept_pad.h"
#include "cuda/cycle/contact_collector.cuh"

namespace deformable_contact_monitor {
namespace {

// Returns whether a pair is a contact, and sets the time interval of the contact. It starts from
// what the device found out. If the straight paths do not meet, the pad may still make the pair a
// contact; `times.high` is then -1.
bool decideOne(const OpenPair& pair, bool wants_time, ContactTimes& times) {
  SweptVerdict quick;
  quick.part = PartVerdict::kOpen;
  quick.first_low = pair.low;
  quick.first_high = pair.high;
  quick.open = pair.open;
  quick.meets_at_end = pair.meets_at_end != 0;
  PredicateState state;
  const SharedVertices shared = sharedByBits(pair.shared & 7, pair.shared >> 3);
  const SweptVerdict verdict = decideOpen(pair.a, pair.b, shared, wants_time, quick, state);
  times = {verdict.first_low, verdict.first_high};
  if (verdict.part == PartVerdict::kMeet) return true;
  if (pair.pad_m == 0 || shared.any) return false;
  const PadVerdict pad = withinPad(pair.a, pair.b, pair.pad_m);
  times = {pad.first_low, -1};
  return pad.may_touch;
}

}  // namespace

void OpenPairs::decide(const CycleArrays& cycle, std::uint32_t count, const Options& options,
                       const CycleLimit& limit, cudaStream_t stream) {
  if (count == 0) return;
  taken_ += count;
  pairs_.grow(count);
  checkCuda(cudaMemcpyAsync(pairs_.data(), cycle.contacts.open_pairs.data(),
                            count * sizeof(OpenPair), cudaMemcpyDeviceToHost, stream),
            "cudaMemcpyAsync to the host");
  checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  decided_.assign(count, {0, 0, {0, 0}});
  constexpr std::size_t kBlock = 4;  // takes about 0.1 ms, after which the limit is checked
  parallelBlocks(limit, count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const OpenPair& pair = pairs_[i];
      ContactTimes times;
      if (!decideOne(pair, options.first_times, times)) continue;
      const std::uint32_t a = pair.triangle_a.value, b = pair.triangle_b.value;
      decided_[i] = {std::min(a, b), std::max(a, b), times};
    }
  });
  for (const Contact& contact : decided_) {
    if (contact.lower != contact.higher) contacts_.push_back(contact);
  }
}

// Merges the contacts of the host, sorted, into the list of the device. It goes from the back, so
// that only contacts after the first new one are moved.
void OpenPairs::addTo(const DeviceScene& scene, const Options& options, DetectionResult& result) {
  if (contacts_.empty()) return;
  std::sort(contacts_.begin(), contacts_.end(), [](const Contact& x, const Contact& y) {
    return x.lower != y.lower ? x.lower < y.lower : x.higher < y.higher;
  });
  const bool times = options.first_times, pads = scene.anyLengths().pads;
  std::size_t from = result.contacts.size(), to = from + contacts_.size();
  result.contacts.resize(to);
  if (times) result.first_times.resize(to);
  if (pads) result.within_pad.resize(to);
  for (std::size_t k = contacts_.size(); k > 0; --k) {
    const Contact& contact = contacts_[k - 1];
    const TriangleIndex a(static_cast<std::uint32_t>(contact.lower));
    const TriangleIndex b(static_cast<std::uint32_t>(contact.higher));
    const TrianglePair pair = scene.pairOf(a, b);
    for (; from > 0 && pair < result.contacts[from - 1]; --from) {
      --to;
      result.contacts[to] = result.contacts[from - 1];
      if (times) result.first_times[to] = result.first_times[from - 1];
      if (pads) result.within_pad[to] = result.within_pad[from - 1];
    }
    --to;
    const bool pad_alone = contact.times.high < 0;
    result.contacts[to] = pair;
    if (times) result.first_times[to] = {contact.times.low, pad_alone ? 1 : contact.times.high};
    if (pads) result.within_pad[to] = pad_alone ? 1 : 0;
  }
}

void ContactCollector::begin() {
  decide_ms_ = 0;
  all_decided_ = true;
  dropOpenPairs();
}

void ContactCollector::fetch(const Options& options, const CycleLimit& limit) {
  const std::uint32_t most =
      limit.isSet() ? kMostListedLate : std::numeric_limits<std::uint32_t>::max();
  const bool swept = options.motion == Motion::kSwept;
  const BodyLengths any = cycle_.scene.anyLengths();
  const ContactFields fields{any.margins && !swept, options.geometry, options.first_times,
                             any.pads && swept};
  output_.fetch(cycle_.arrays, fields, std::min(cycle_.listable(last_contacts_), most), most,
                result_, cycle_.stream.get());
}

// Grows the page-locked memory step by step where a limit is set, so that the cycle ends in time
// with as many contacts as there is room for by then.
void ContactCollector::complete(const CycleLimit& limit) {
  std::uint32_t count = cycle_.listable(cycle_.counted().contacts);
  if (limit.over()) count = std::min(count, kMostListedLate);
  if (output_.has(count)) return;
  const cudaStream_t stream = cycle_.stream.get();
  // Allocating page-locked memory takes long, so the limit is checked in between.
  std::uint32_t room = limit.isSet() ? std::min(count, kMostListedLate) : count;
  output_.makeRoom(room, result_, stream);
  while (room < count && !limit.over()) {
    room = std::min(count, 2 * room);
    output_.makeRoom(room, result_, stream);
  }
  output_.fetchAgain(cycle_.arrays, cycle_.params[0].index_bits, room, result_, stream);
  checkCuda(cudaGetLastError(), "a launch");
  cycle_.wait(limit);
}

void ContactCollector::decideOpenPairs(const Options& options, const CycleLimit& limit) {
  const Stopwatch watch{};
  const std::uint32_t open = cycle_.counted().open_pairs;
  all_had_room_ = all_had_room_ && open <= cycle_.sizes.open_pairs;
  open_pairs_.decide(cycle_.arrays, std::min(open, cycle_.sizes.open_pairs), options, limit,
                     cycle_.stream.get());
  decide_ms_ += watch.elapsedMs();
  all_decided_ = all_decided_ && !limit.wasOver();
}

bool ContactCollector::addTo(const Options& options) {
  const std::uint64_t found = cycle_.counted().contacts;
  output_.list(cycle_.listable(found), result_);
  result_.left_out = found - result_.contacts.size();
  const bool all_listed = result_.contacts.size() >= cycle_.listable(found);
  open_pairs_.addTo(cycle_.scene, options, result_);
  last_contacts_ = found;
  return all_listed;
}

}  // namespace deformable_contact_monitor
