// Fetches contacts in two steps. The first fetch is enqueued before the number of contacts is
// known, with room for as many as the last cycle had; complete() fetches what is missing.
#include <algorithm>
#include <limits>

#include "core/common/stopwatch.h"
#include "cuda/cycle/contact_collector.cuh"

namespace deformable_contact_monitor {

void ContactCollector::begin() {
  decide_ms_ = 0;
  all_decided_ = true;
  open_pairs_.clear();
}

void ContactCollector::fetch(const Options& options, const CycleLimit& limit) {
  const std::uint32_t most =
      limit.isSet() ? kMostListedLate : std::numeric_limits<std::uint32_t>::max();
  const bool swept = options.motion == Motion::kSwept;
  const BodyLengths any = cycle_.scene.anyLengths();
  const ContactFields fields{any.margins && !swept, options.geometry, options.first_times,
                             any.pads && swept};
  output_.fetch(cycle_.arrays, fields, std::min(cycle_.listable(last_contacts_), most), most,
                result_.contacts, cycle_.stream.get());
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
  output_.makeRoom(room, result_.contacts, stream);
  while (room < count && !limit.over()) {
    room = std::min(count, 2 * room);
    output_.makeRoom(room, result_.contacts, stream);
  }
  output_.fetchAgain(cycle_.arrays, cycle_.params[0].index_bits, room, result_.contacts, stream);
  checkCuda(cudaGetLastError(), "a launch");
  cycle_.wait(limit);
}

void ContactCollector::decideOpenPairs(const Options& options, const CycleLimit& limit) {
  const Stopwatch watch{};
  open_pairs_.decide(cycle_.arrays, std::min(cycle_.counted().open_pairs, cycle_.sizes.open_pairs),
                     options, limit, cycle_.stream.get());
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
