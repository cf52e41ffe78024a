// What is lost where frames are looked at one by one, or only some of them.
#include "tools/measure_trade/motion_statistics.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace deformable_contact_monitor {
namespace {

using Pairs = std::vector<TrianglePair>;

struct Timed {
  TrianglePair pair;
  FirstContact first;
};

TrianglePair atLevel(const TrianglePair& pair, MotionLevel level) {
  return level == MotionLevel::kTriangles ? pair : TrianglePair(pair.body_a, 0, pair.body_b, 0);
}

// Sorted, each once.
Pairs atLevel(const Pairs& pairs, MotionLevel level) {
  Pairs mapped;
  mapped.reserve(pairs.size());
  for (const TrianglePair& pair : pairs) mapped.push_back(atLevel(pair, level));
  std::sort(mapped.begin(), mapped.end());
  mapped.erase(std::unique(mapped.begin(), mapped.end()), mapped.end());
  return mapped;
}

// Sorted, each once, with the earliest times.
std::vector<Timed> timedAtLevel(const MotionStep& step, MotionLevel level) {
  std::vector<Timed> timed;
  for (std::size_t i = 0; i < step.contacts.size(); ++i) {
    timed.push_back({atLevel(step.contacts[i], level), step.first[i]});
  }
  std::stable_sort(timed.begin(), timed.end(),
                   [](const Timed& a, const Timed& b) { return a.pair < b.pair; });
  std::vector<Timed> merged;
  for (const Timed& next : timed) {
    if (merged.empty() || !(merged.back().pair == next.pair)) {
      merged.push_back(next);
      continue;
    }
    FirstContact& first = merged.back().first;
    first.low = std::min(first.low, next.first.low);
    first.high = std::min(first.high, next.first.high);
  }
  return merged;
}

void add(const Pairs& more, Pairs* all) {
  Pairs merged;
  merged.reserve(all->size() + more.size());
  std::set_union(all->begin(), all->end(), more.begin(), more.end(), std::back_inserter(merged));
  all->swap(merged);
}

// Of the stretch between two frames.
Pairs seenIn(const MotionResults& found, const MotionWay& way, std::size_t from, std::size_t to) {
  Pairs seen;
  for (std::size_t frame = from; frame <= to; frame += way.kept_alone ? to - from : 1) {
    add(found.instant[frame], &seen);
  }
  if (way.motion == Motion::kInstant) return seen;
  for (const MotionStep& step : way.kept_alone ? found.kept_steps : found.steps) {
    if (step.from >= from && step.to <= to) add(step.contacts, &seen);
  }
  return seen;
}

constexpr MotionWay kTruth = {Motion::kSwept, false};

bool wasLookedAt(const MotionStep& step, const TrianglePair& pair) {
  return std::binary_search(step.bodies.begin(), step.bodies.end(),
                            BodyPair(pair.body_a, pair.body_b));
}

std::vector<Onset> onsets(const MotionResults& found, const MotionWay& way, MotionLevel level) {
  const std::vector<MotionStep>& steps = way.kept_alone ? found.kept_steps : found.steps;
  std::vector<Onset> all;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const MotionStep& step = steps[i];
    const Pairs before = atLevel(found.instant[step.from], level);
    const auto is_new = [&](const TrianglePair& pair) {
      return wasLookedAt(step, pair) && !std::binary_search(before.begin(), before.end(), pair);
    };
    if (way.motion == Motion::kInstant) {
      const auto at = static_cast<double>(step.to);
      for (const TrianglePair& pair : atLevel(found.instant[step.to], level)) {
        if (is_new(pair)) all.push_back({pair, i, at, at});
      }
      continue;
    }
    const auto from = static_cast<double>(step.from), length = static_cast<double>(step.to) - from;
    for (const Timed& timed : timedAtLevel(step, level)) {
      if (!is_new(timed.pair)) continue;
      all.push_back(
          {timed.pair, i, from + length * timed.first.low, from + length * timed.first.high});
    }
  }
  return all;
}

}  // namespace

const std::vector<MotionWay>& waysToLook() {
  static const std::vector<MotionWay> kWays = {
      {Motion::kInstant, false}, {Motion::kInstant, true}, {Motion::kSwept, true}};
  return kWays;
}

LostContacts lostContacts(const MotionResults& found, const MotionWay& way, MotionLevel level) {
  LostContacts sum;
  for (const MotionStep& stretch : found.kept_steps) {
    const Pairs truth = atLevel(seenIn(found, kTruth, stretch.from, stretch.to), level);
    const Pairs seen = atLevel(seenIn(found, way, stretch.from, stretch.to), level);
    Pairs common;
    std::set_intersection(truth.begin(), truth.end(), seen.begin(), seen.end(),
                          std::back_inserter(common));
    sum.truth += truth.size();
    sum.found += seen.size();
    sum.common += common.size();
  }
  return sum;
}

std::vector<Onset> trueOnsets(const MotionResults& found, MotionLevel level) {
  return onsets(found, kTruth, level);
}

std::uint64_t FoundOnsets::lost() const {
  return static_cast<std::uint64_t>(std::count(of_truth.begin(), of_truth.end(), std::nullopt));
}

FoundOnsets findOnsets(const MotionResults& found, const MotionWay& way, MotionLevel level,
                       const std::vector<Onset>& truth) {
  std::map<std::pair<std::size_t, TrianglePair>, Onset> seen;
  for (const Onset& onset : onsets(found, way, level)) {
    seen.emplace(std::make_pair(onset.interval, onset.pair), onset);
  }
  FoundOnsets answer;
  for (const Onset& onset : truth) {
    const std::size_t interval = way.kept_alone ? onset.interval / found.every : onset.interval;
    const auto at = seen.find({interval, onset.pair});
    if (at == seen.end()) {
      answer.of_truth.emplace_back();
      continue;
    }
    answer.of_truth.emplace_back(at->second);
    seen.erase(at);
  }
  answer.added = seen.size();
  return answer;
}

TimeError timeError(const std::vector<Onset>& truth, const FoundOnsets& found) {
  TimeError error;
  std::size_t count = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!found.of_truth[i]) continue;
    const double off = std::abs(found.of_truth[i]->low - truth[i].low);
    error.mean += off;
    error.worst = std::max(error.worst, off);
    ++count;
  }
  if (count > 0) error.mean /= static_cast<double>(count);
  return error;
}

}  // namespace deformable_contact_monitor
