// What a result is worth beside the exact one, and which settings are worth their time.
#include "tools/measure_trade/trade_statistics.h"

#include <algorithm>
#include <tuple>

namespace deformable_contact_monitor {
namespace {

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 1 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

void PairCounts::add(const PairCounts& o) {
  truth += o.truth;
  found += o.found;
  common += o.common;
}

double PairCounts::recall() const { return share(common, truth); }
double PairCounts::precision() const { return share(common, found); }

FrameCounts compare(const std::vector<TrianglePair>& truth,
                    const std::vector<TrianglePair>& found) {
  FrameCounts counts;
  auto t = truth.begin();
  auto f = found.begin();
  while (t != truth.end() || f != found.end()) {
    const bool is_true = f == found.end() || (t != truth.end() && !(*f < *t));
    const bool is_found = t == truth.end() || (f != found.end() && !(*t < *f));
    const TrianglePair& pair = is_true ? *t : *f;
    counts[{pair.body_a, pair.body_b}].add({is_true, is_found, is_true && is_found});
    if (is_true) ++t;
    if (is_found) ++f;
  }
  return counts;
}

PairCounts total(const FrameCounts& counts, ContactKind kind) {
  PairCounts sum;
  for (const auto& [bodies, pairs] : counts) {
    const bool self = bodies.first == bodies.second;
    if (kind == ContactKind::kAny || self == (kind == ContactKind::kSelf)) sum.add(pairs);
  }
  return sum;
}

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

OnsetDelay onsetDelay(const std::vector<bool>& truth, const std::vector<bool>& found) {
  OnsetDelay all;
  for (std::size_t begin = 0; begin < truth.size();) {
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

std::optional<std::size_t> choose(const std::vector<Worth>& settings,
                                  std::optional<double> budget_ms) {
  const auto rank = [](const Worth& w) {
    return std::make_tuple(w.recall, w.precision, w.guaranteed, -w.median_ms);
  };
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const Worth& setting = settings[i];
    if (budget_ms ? setting.p95_ms > *budget_ms : !setting.guaranteed) continue;
    if (!best || rank(setting) > rank(settings[*best])) best = i;
  }
  return best;
}

std::size_t fastest(const std::vector<Worth>& settings) {
  const auto faster = [](const Worth& a, const Worth& b) { return a.median_ms < b.median_ms; };
  const auto found = std::min_element(settings.begin(), settings.end(), faster);
  return static_cast<std::size_t>(found - settings.begin());
}

}  // namespace deformable_contact_monitor
