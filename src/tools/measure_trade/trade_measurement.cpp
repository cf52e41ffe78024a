// Runs settings over a sequence of frames, and compares what they find with the exact contacts.
#include "tools/measure_trade/trade_measurement.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "core/cpu_detector.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

// Returns the counts of two bodies; zeros if they have no contact.
PairCounts countsOf(const FrameCounts& counts, const BodyPair& bodies) {
  const auto found = counts.find(bodies);
  return found == counts.end() ? PairCounts() : found->second;
}

// Returns how the guarantee is broken; empty: it holds. No contact may be missing. Exact predicates
// must add none either; conservative ones may.
std::string howBroken(const Setting& setting, const PairCounts& pairs, const std::string& frame) {
  const bool may_add = setting.options.predicates != Predicates::kExact;
  if (pairs.lost() == 0 && (may_add || pairs.added() == 0)) return "";
  return describe(setting) + " is guaranteed, but misses " + std::to_string(pairs.lost()) +
         " of the exact contacts and adds " + std::to_string(pairs.added()) + " in " + frame;
}

// Adds the rates of a frame, and remembers the first frame in which a guarantee is broken.
void addFrame(const FrameCounts& counts, const ExactResults& exact, std::size_t frame,
              Measurement* sum) {
  sum->external.add(total(counts, ContactKind::kExternal).recall(), frame);
  sum->self.add(total(counts, ContactKind::kSelf).recall(), frame);
  const PairCounts all = total(counts, ContactKind::kAny);
  sum->precision.add(all.precision(), frame);
  for (const BodyPair& bodies : exact.bodies) {
    sum->bodies[bodies].recall.add(countsOf(counts, bodies).recall(), frame);
  }
  if (sum->guaranteed && sum->broken.empty()) {
    sum->broken = howBroken(sum->setting, all, exact.labels[frame]);
  }
}

// Adds the onset delays of one pass through the frames, for each pair of bodies.
void addOnsets(const std::vector<FrameCounts>& pass, const ExactResults& exact, Measurement* sum) {
  for (const BodyPair& bodies : exact.bodies) {
    std::vector<bool> truth, found;
    for (const FrameCounts& counts : pass) {
      const PairCounts pairs = countsOf(counts, bodies);
      truth.push_back(pairs.truth > 0);
      found.push_back(pairs.found > 0);
    }
    const OnsetDelay delay = onsetDelay(truth, found);
    sum->bodies[bodies].onset.add(delay);
    sum->onset.add(delay);
  }
}

}  // namespace

void forEachCycle(FrameSource* frames, const CycleCounts& cycles,
                  const std::function<void(std::size_t frame, bool is_counted)>& visit) {
  int warm_up = cycles.warm_up;
  for (int pass = 0; pass < cycles.passes || warm_up > 0;) {
    const bool is_counted = warm_up <= 0;
    frames->rewind();
    for (std::size_t frame = 0; frames->next(); ++frame, --warm_up) visit(frame, is_counted);
    pass += is_counted ? 1 : 0;
  }
}

// The noise comes from the medians and 95th percentiles of the single repeats.
Worth Measurement::worth() const {
  Worth worth = {median(round_trip_ms), percentile(round_trip_ms, 0.95),
                 std::min(external.worst, self.worst), precision.worst,
                 guaranteed && broken.empty()};
  std::vector<double> medians, p95s;
  // The cycles of all repeats stand one after the other in round_trip_ms.
  auto begin = round_trip_ms.begin();
  for (const std::size_t cycles : repeats) {
    const auto end = begin + static_cast<std::ptrdiff_t>(cycles);
    const std::vector<double> ms(begin, end);
    medians.push_back(median(ms));
    p95s.push_back(percentile(ms, 0.95));
    begin = end;
  }
  worth.median_noise = spreadAround(worth.median_ms, medians);
  worth.p95_noise = spreadAround(worth.p95_ms, p95s);
  worth.strictness = strictness(setting.options);
  return worth;
}

// The defaults need no configuration, so they are preferred unless another setting is faster beyond
// the noise.
std::size_t defaultsIfAsGood(const std::vector<Measurement>& all, std::size_t chosen,
                             std::optional<double> budget_ms) {
  const Worth best = all[chosen].worth();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Worth worth = all[i].worth();
    const bool finds_as_much = worth.recall >= best.recall && worth.precision >= best.precision &&
                               worth.guaranteed >= best.guaranteed;
    const bool is_over_budget =
        budget_ms && worth.p95_ms > *budget_ms && worth.p95_ms > best.p95_ms;
    if (isDefault(all[i].setting) && all[i].setting.backend == all[chosen].setting.backend &&
        finds_as_much && !is_over_budget && isMedianWithinNoise(worth, best)) {
      return i;
    }
  }
  return chosen;
}

// Uses the default options: exact predicates and overlap 1 find every contact by proof.
ExactResults exactResults(FrameSource* frames, AdjacentPairs adjacent,
                          const SayProgress& progress) {
  Options options;
  options.adjacent = adjacent;
  ExactResults exact;
  std::set<BodyPair> bodies;
  const std::unique_ptr<Detector> detector = makeCpuDetector();
  frames->rewind();
  while (frames->next()) {
    progress("exact contacts of " + frames->label());
    const DetectionResult& result = detector->detect(frames->scene(), options);
    exact.contacts.push_back(result.contacts);
    exact.rejected += result.counters.rejected;
    exact.labels.push_back(frames->label());
    for (const TrianglePair& pair : exact.contacts.back()) bodies.emplace(pair.body_a, pair.body_b);
  }
  if (exact.contacts.empty()) throw std::runtime_error("there is no frame to measure");
  exact.bodies.assign(bodies.begin(), bodies.end());
  return exact;
}

// Cold starts happen in the warm-up, which may need more cycles than there are frames.
void measure(FrameSource* frames, const ExactResults& exact, const CycleCounts& cycles,
             Detector* detector, const SayProgress& progress, Measurement* sum) {
  const Setting& setting = sum->setting;
  // An incomplete result would look like a bad setting, so it ends the measurement.
  const auto detect = [&]() -> const DetectionResult& {
    const DetectionResult& result = detector->detect(frames->scene(), setting.options);
    if (result.cut_off) {
      throw std::runtime_error(describe(setting) + " was cut off: " + result.cut_off_because);
    }
    if (result.left_out == 0) return result;
    throw std::runtime_error(describe(setting) + ": " + std::to_string(result.left_out) +
                             " contacts did not fit into the device memory allowed for them");
  };
  frames->rewind();
  progress("warming up");
  for (int cycle = 0; cycle < cycles.warm_up; ++cycle) {
    if (!frames->next()) {
      frames->rewind();
      frames->next();
    }
    detect();
  }
  // Every cycle counts from here on.
  sum->repeats.push_back(0);
  for (int pass = 0; pass < cycles.passes; ++pass) {
    frames->rewind();
    std::vector<FrameCounts> counts;
    while (frames->next()) {
      progress("pass " + std::to_string(pass + 1) + " of " + std::to_string(cycles.passes) + ", " +
               frames->label());
      const DetectionResult& result = detect();
      const std::size_t frame = counts.size();
      counts.push_back(compare(exact.contacts.at(frame), result.contacts));
      sum->round_trip_ms.push_back(result.round_trip_ms);
      ++sum->repeats.back();
      sum->guaranteed = sum->guaranteed && result.guaranteed;
      sum->work.addWork(result.counters);
      sum->work.clusters += result.counters.clusters;
      addFrame(counts.back(), exact, frame, sum);
    }
    addOnsets(counts, exact, sum);
  }
}

}  // namespace deformable_contact_monitor
