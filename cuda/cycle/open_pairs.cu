// Decides pairs of swept motion on the host with exact arithmetic, and merges those that are
// contacts into the device's sorted list.
#include <algorithm>

#include "core/common/parallel.h"
#include "core/predicates/swept_exact.h"
#include "core/predicates/swept_pad.h"
#include "cuda/cycle/open_pairs.cuh"

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

}  // namespace deformable_contact_monitor
