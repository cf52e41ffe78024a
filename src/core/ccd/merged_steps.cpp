// Merges the results of sub-steps. Contacts of all parts are sorted, so each new list is merged
// with the old one in a single pass. Times are rounded outwards, so that they still enclose the
// true time.
#include "core/ccd/merged_steps.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/common/work_counters.h"

namespace deformable_contact_monitor {
namespace {

// Bounds the relative error of the double arithmetic below.
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

// Converts times within a sub-step into times within the whole interval.
FirstContact inInterval(const FirstContact& first, double from, double to) {
  if (from == 0 && to == 1) return first;
  return {roundedDown(from + (to - from) * first.low), roundedUp(from + (to - from) * first.high)};
}

// Adds up the work of the sub-steps. Rejected triangles and clusters are the same ones in each
// sub-step, so their largest count is taken.
void addCounters(const Counters& part, Counters& sum) {
  sum.rejected = std::max(sum.rejected, part.rejected);
  sum.posed += part.posed;
  sum.culled += part.culled;
  sum.clusters = std::max(sum.clusters, part.clusters);
  addWork(part, sum);
}

// Adds up the times of stages with the same name.
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
    first = inInterval(first, from, to);
    // It is not known when triangles within their pads touch, or whether they do, so 1 is the only
    // upper bound.
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

// A contact within the pads may come before one on the straight lines, and its upper bound is 1.
MergedSteps::Contact MergedSteps::merged(const Contact& earlier, const Contact& later) {
  return {earlier.pair,
          {std::min(earlier.first.low, later.first.low),
           std::min(earlier.first.high, later.first.high)},
          earlier.within_pad && later.within_pad};
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
