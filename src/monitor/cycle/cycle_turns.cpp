// Whose cycle is next: objects take turns, so that none starves beside a faster or an earlier one.
#include "monitor/cycle/cycle_turns.h"

#include <algorithm>

namespace deformable_contact_monitor {

CycleTurns::CycleTurns(const std::vector<double>& max_rates_hz) : entries_(max_rates_hz.size()) {
  setRates(max_rates_hz);
}

void CycleTurns::setRates(const std::vector<double>& max_rates_hz) {
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    Entry& entry = entries_[i];
    const SteadyTime::duration before = entry.period;
    entry.period = max_rates_hz[i] > 0 ? fromSeconds(1 / max_rates_hz[i]) : SteadyTime::duration();
    if (entry.earliest > SteadyTime()) entry.earliest += entry.period - before;
  }
}

bool CycleTurns::anyWaits() const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [](const Entry& entry) { return !entry.waiting.empty(); });
}

bool CycleTurns::mayWait(std::size_t who, SteadyTime now) const {
  const Entry& entry = entries_[who];
  return entry.waiting.size() < kMostWaiting && (isLastReplaceable(who) || now >= entry.earliest);
}

bool CycleTurns::isLastReplaceable(std::size_t who) const {
  const Queue& waiting = entries_[who].waiting;
  return !waiting.empty() && !waiting.back().held_up;
}

// One that comes late by less than a period does not put off those after it, or meshes that are as
// fast as the rate would fall behind it more and more.
void CycleTurns::wait(std::size_t who, const Waiting& waiting, SteadyTime now) {
  Entry& entry = entries_[who];
  entry.waiting.push_back(waiting);
  const bool is_punctual = now - entry.earliest < entry.period;
  entry.earliest = (is_punctual ? entry.earliest : now) + entry.period;
}

void CycleTurns::replaceLast(std::size_t who, const Waiting& waiting) {
  entries_[who].waiting.back() = waiting;
}

void CycleTurns::holdUp(std::size_t who) {
  for (Waiting& waiting : entries_[who].waiting) waiting.held_up = true;
}

// Who is asked may be costly to answer: the one whose turn it is comes first.
std::vector<std::size_t> CycleTurns::next(const std::function<bool(std::size_t)>& is_ready) const {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (!entries_[i].waiting.empty()) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
    return entries_[a].last_turn < entries_[b].last_turn;
  });
  const auto first = std::find_if(order.begin(), order.end(), is_ready);
  if (first == order.end()) return {};
  std::vector<std::size_t> together{*first};
  if (entries_[*first].overran) return together;
  for (auto other = first + 1; other != order.end(); ++other) {
    const bool same_stamp =
        entries_[*other].waiting.front().stamp == entries_[*first].waiting.front().stamp;
    if (same_stamp && !entries_[*other].overran && is_ready(*other)) together.push_back(*other);
  }
  std::sort(together.begin(), together.end());
  return together;
}

void CycleTurns::start(const std::vector<std::size_t>& who) {
  ++turns_;
  for (const std::size_t i : who) {
    entries_[i].waiting.pop_front();
    entries_[i].last_turn = turns_;
  }
}

void CycleTurns::finish(const std::vector<std::size_t>& who, bool overran) {
  for (const std::size_t i : who) entries_[i].overran = overran;
}

void CycleTurns::clear() {
  for (Entry& entry : entries_) {
    entry.waiting.clear();
    entry.overran = false;
  }
}

}  // namespace deformable_contact_monitor
