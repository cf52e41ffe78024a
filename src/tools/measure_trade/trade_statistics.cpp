// Counts recall, precision and delays, and chooses a setting. Two times count as equal if the
// ranges of their repeats overlap, so that noise does not decide.
#include "tools/measure_trade/trade_statistics.h"

#include <algorithm>
#include <tuple>

namespace deformable_contact_monitor {
namespace {

// Returns true if the ranges of two figures overlap.
bool overlap(double a, const Spread& of_a, double b, const Spread& of_b) {
  return a - of_a.below <= b + of_b.above && b - of_b.below <= a + of_a.above;
}

// Returns the criteria that precede time, in their order.
std::tuple<double, double, bool> accuracy(const Worth& w) {
  return {w.recall, w.precision, w.guaranteed};
}

// Returns the best of the settings `of`: by accuracy, then by strictness among those as fast as the
// fastest, then by speed.
std::size_t bestOf(const std::vector<Worth>& settings, const std::vector<std::size_t>& of) {
  std::size_t fastest = of.front();
  for (const std::size_t i : of) {
    const auto rank = [&](std::size_t k) {
      return std::make_tuple(accuracy(settings[k]), -settings[k].median_ms);
    };
    if (rank(i) > rank(fastest)) fastest = i;
  }
  std::size_t best = fastest;
  for (const std::size_t i : of) {
    const Worth& setting = settings[i];
    // Only equally accurate settings compete in strictness.
    if (accuracy(setting) != accuracy(settings[fastest])) continue;
    if (!isMedianWithinNoise(setting, settings[fastest])) continue;
    const auto rank = [&](std::size_t k) {
      return std::make_tuple(settings[k].strictness, -settings[k].median_ms);
    };
    if (rank(i) > rank(best)) best = i;
  }
  return best;
}

}  // namespace

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 1 : static_cast<double>(part) / static_cast<double>(whole);
}

// Counts of several pairs of bodies simply add up.
void PairCounts::add(const PairCounts& o) {
  truth += o.truth;
  found += o.found;
  common += o.common;
}

// Walks through both sorted lists at once. A pair is true, found, or both.
FrameCounts compare(const std::vector<TrianglePair>& truth,
                    const std::vector<TrianglePair>& found) {
  FrameCounts counts;
  auto t = truth.begin();
  auto f = found.begin();
  while (t != truth.end() || f != found.end()) {
    // The smaller pair comes next; equal pairs advance both lists.
    const bool is_true = f == found.end() || (t != truth.end() && !(*f < *t));
    const bool is_found = t == truth.end() || (f != found.end() && !(*t < *f));
    const TrianglePair& pair = is_true ? *t : *f;
    counts[{pair.body_a, pair.body_b}].add({is_true, is_found, is_true && is_found});
    if (is_true) ++t;
    if (is_found) ++f;
  }
  return counts;
}

// Sums the counts of one kind of contact.
PairCounts total(const FrameCounts& counts, ContactKind kind) {
  PairCounts sum;
  for (const auto& [bodies, pairs] : counts) {
    const bool self = bodies.first == bodies.second;
    if (kind == ContactKind::kAny || self == (kind == ContactKind::kSelf)) sum.add(pairs);
  }
  return sum;
}

// Keeps the first frame with the worst rate, so that reports can name it.
void RateOverFrames::add(double rate, std::size_t frame) {
  if (rate < worst) {
    worst = rate;
    worst_frame = frame;
  }
  sum += rate;
  ++count;
}

void OnsetDelay::add(const OnsetDelay& o) {
  runs += o.runs;
  missed += o.missed;
  worst = std::max(worst, o.worst);
  sum += o.sum;
}

// Goes through the runs of frames with true contact, and counts the frames until one is found.
OnsetDelay onsetDelay(const std::vector<bool>& truth, const std::vector<bool>& found) {
  OnsetDelay all;
  for (std::size_t begin = 0; begin < truth.size();) {
    // Skips frames without true contact.
    if (!truth[begin]) {
      ++begin;
      continue;
    }
    std::size_t end = begin;
    while (end < truth.size() && truth[end]) ++end;
    std::size_t noticed = begin;
    while (noticed < end && !found[noticed]) ++noticed;
    const std::size_t delay = noticed - begin;
    all.add({1, noticed == end ? std::size_t{1} : 0, delay, delay});
    begin = end;
  }
  return all;
}

// Compares each setting with each other: there are a few hundred at most.
std::vector<bool> paretoFront(const std::vector<Worth>& settings) {
  const auto beats = [](const Worth& a, const Worth& b) {
    const bool as_good =
        a.median_ms <= b.median_ms && a.recall >= b.recall && a.precision >= b.precision;
    return as_good &&
           (a.median_ms < b.median_ms || a.recall > b.recall || a.precision > b.precision);
  };
  std::vector<bool> front;
  front.reserve(settings.size());
  for (const Worth& setting : settings) {
    front.push_back(std::none_of(settings.begin(), settings.end(),
                                 [&](const Worth& other) { return beats(other, setting); }));
  }
  return front;
}

// The step between predicates is larger than any overlap, which is at most 1.
double strictness(const Options& options) {
  constexpr double kStep = 2;
  return (options.predicates == Predicates::kExact ? kStep : 0) + double{options.overlap};
}

// The figure itself need not be one of the repeats' figures.
Spread spreadAround(double figure, const std::vector<double>& of_repeats) {
  Spread spread;
  for (const double repeat : of_repeats) {
    spread.below = std::max(spread.below, figure - repeat);
    spread.above = std::max(spread.above, repeat - figure);
  }
  return spread;
}

bool isMedianWithinNoise(const Worth& a, const Worth& b) {
  return overlap(a.median_ms, a.median_noise, b.median_ms, b.median_noise);
}

bool isP95WithinNoise(const Worth& a, const Worth& b) {
  return overlap(a.p95_ms, a.p95_noise, b.p95_ms, b.p95_noise);
}

// `allowed` keep the budget; `doubtful` keep it only in some repeats.
std::optional<std::size_t> choose(const std::vector<Worth>& settings,
                                  std::optional<double> budget_ms) {
  std::vector<std::size_t> allowed, doubtful;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const Worth& setting = settings[i];
    if (budget_ms ? setting.p95_ms <= *budget_ms : setting.guaranteed) {
      allowed.push_back(i);
    } else if (budget_ms && setting.p95_ms - setting.p95_noise.below <= *budget_ms) {
      doubtful.push_back(i);
    }
  }
  if (allowed.empty()) return std::nullopt;
  const std::size_t best = bestOf(settings, allowed);
  // A doubtful setting wins only if it is more accurate, and its time cannot be told from the best
  // one's.
  std::vector<std::size_t> better;
  for (const std::size_t i : doubtful) {
    if (accuracy(settings[i]) > accuracy(settings[best]) &&
        isP95WithinNoise(settings[i], settings[best])) {
      better.push_back(i);
    }
  }
  return better.empty() ? best : bestOf(settings, better);
}

std::vector<std::size_t> asFast(const std::vector<Worth>& settings, std::size_t chosen) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    if (i != chosen && isMedianWithinNoise(settings[i], settings[chosen])) others.push_back(i);
  }
  return others;
}

std::size_t fastest(const std::vector<Worth>& settings) {
  const auto faster = [](const Worth& a, const Worth& b) { return a.median_ms < b.median_ms; };
  const auto found = std::min_element(settings.begin(), settings.end(), faster);
  return static_cast<std::size_t>(found - settings.begin());
}

}  // namespace deformable_contact_monitor
