#include "core/ccd/merged_steps.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace deformable_contact_monitor {
namespace {

// What double arithmetic may be off by here, and more.
constexpr double kSlack = 0x1p-50;

float roundedDown(double x) {
  const double least = x * (1 - kSlack);
  const auto near = static_cast<float>(least);
  return near > least ? std::nextafter(near, 0.0F) : near;
}

float roundedUp(double x) {
  const double most = x * (1 + kSlack);
  const auto near = static_cast<float>(most);
  return std::min(near < most ? std::nextafter(near, 2.0F) : near, 1.0F);
}

FirstContact inStep(const FirstContact& first, double from, double to) {
  if (from == 0 && to == 1) return first;
  return {roundedDown(from + (to - from) * first.low), roundedUp(from + (to - from) * first.high)};
}

void addCounters(const Counters& part, Counters& sum) {
  sum.rejected = std::max(sum.rejected, part.rejected);
  sum.posed += part.posed;
  sum.culled += part.culled;
  sum.clustered += part.clustered;
  sum.large += part.large;
  sum.clusters = std::max(sum.clusters, part.clusters);
  sum.cluster_entries += part.cluster_entries;
  sum.largest_cluster = std::max(sum.largest_cluster, part.largest_cluster);
  sum.interval_overlaps += part.interval_overlaps;
  sum.candidates += part.candidates;
  sum.exact += part.exact;
  sum.undecided += part.undecided;
}

void addTimes(const DetectionResult& part, DetectionResult& sum) {
  for (const auto& [stage, ms] : part.stages_ms) {
    const auto known = std::find_if(sum.stages_ms.begin(), sum.stages_ms.end(),
                                    [&stage = stage](const auto& s) { return s.first == stage; });
    if (known == sum.stages_ms.end()) {
      sum.stages_ms.emplace_back(stage, ms);
    } else {
      known->second += ms;
    }
  }
  sum.detect_ms += part.detect_ms;
  sum.memory_bytes = std::max(sum.memory_bytes, part.memory_bytes);
}

}  // namespace

void MergedSteps::add(const DetectionResult& part, double from, double to) {
  addContacts(part, from, to);
  sums_.left_out += part.left_out;
  if (part.cut_off) sums_.cutOff(part.cut_off_because);
  sums_.started_cold = sums_.started_cold || part.started_cold;
  addCounters(part.counters, sums_.counters);
  addTimes(part, sums_);
}

void MergedSteps::addContacts(const DetectionResult& part, double from, double to) {
  new_.clear();
  for (std::size_t i = 0; i < part.contacts.size(); ++i) {
    FirstContact first{0, 1};
    if (!part.first_times.empty()) first = part.first_times[i];
    const bool within_pad = !part.within_pad.empty() && part.within_pad[i] != 0;
    first = inStep(first, from, to);
    if (within_pad) first.high = 1;
    new_.push_back({part.contacts[i], first, within_pad});
  }
  both_.clear();
  auto old = contacts_.cbegin();
  for (const Contact& contact : new_) {
    for (; old != contacts_.cend() && old->pair < contact.pair; ++old) both_.push_back(*old);
    if (old != contacts_.cend() && old->pair == contact.pair) {
      both_.push_back(merged(*old++, contact));
    } else {
      both_.push_back(contact);
    }
  }
  both_.insert(both_.end(), old, contacts_.cend());
  contacts_.swap(both_);
}

// Times of contacts are those on the straight ways, whatever the pads let be before.
MergedSteps::Contact MergedSteps::merged(const Contact& earlier, const Contact& later) {
  if (earlier.within_pad != later.within_pad) return earlier.within_pad ? later : earlier;
  Contact both = earlier;
  both.first.low = std::min(earlier.first.low, later.first.low);
  both.first.high = std::min(earlier.first.high, later.first.high);
  return both;
}

void MergedSteps::write(bool first_times, bool pads, DetectionResult* result) const {
  for (const Contact& contact : contacts_) {
    result->contacts.push_back(contact.pair);
    if (first_times) result->first_times.push_back(contact.first);
    if (pads) result->within_pad.push_back(contact.within_pad ? 1 : 0);
  }
  result->left_out = sums_.left_out;
  result->cut_off = sums_.cut_off;
  result->cut_off_because = sums_.cut_off_because;
  result->started_cold = sums_.started_cold;
  const std::uint64_t triangles = result->counters.triangles;
  result->counters = sums_.counters;
  result->counters.triangles = triangles;
  result->stages_ms = sums_.stages_ms;
  result->detect_ms = sums_.detect_ms;
  result->memory_bytes = sums_.memory_bytes;
}

}  // namespace deformable_contact_monitor
