// Decides whose cycle is next, how long a mesh waits for its transforms, and which meshes have no
// cycle.
#include "monitor/cycle/cycle_scheduler.h"

#include <algorithm>
#include <utility>

namespace deformable_contact_monitor {

CycleScheduler::CycleScheduler(const std::vector<double>& max_rates_hz, MeshInputs& inputs,
                               TransformGate gate)
    : inputs_(inputs), gate_(std::move(gate)), entries_(max_rates_hz.size()) {
  setRates(max_rates_hz);
}

// The last request of each queue counts as if it had been made at the new rate.
void CycleScheduler::setRates(const std::vector<double>& max_rates_hz) {
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    Entry& entry = entries_[i];
    const SteadyTime::duration before = entry.period;
    entry.period = max_rates_hz[i] > 0 ? fromSeconds(1 / max_rates_hz[i]) : SteadyTime::duration();
    if (entry.earliest > SteadyTime()) entry.earliest += entry.period - before;
  }
}

bool CycleScheduler::mayAdd(std::size_t who, SteadyTime now) const {
  const Entry& entry = entries_[who];
  return entry.queue.size() < kMostWaiting && (isLastReplaceable(who) || now >= entry.earliest);
}

// Returns whether the last request of the queue waits only for its turn.
bool CycleScheduler::isLastReplaceable(std::size_t who) const {
  const std::deque<CycleRequest>& queue = entries_[who].queue;
  return !queue.empty() && !queue.back().waits_for_transforms;
}

void CycleScheduler::add(std::size_t who, CycleRequest request, SteadyTime now) {
  Entry& entry = entries_[who];
  if (isRobot(who)) return append(&entry, std::move(request), now);
  std::deque<CycleRequest>& queue = entry.queue;
  while (!queue.empty() && !inputs_[who].has(queue.front().stamp)) dropFirst(who);
  if (!queue.empty() && queue.back().stamp == request.stamp) {
    // The cycle that waits keeps its time and has the newer mesh.
    request.mesh.arrival = queue.back().mesh.arrival;
    queue.back().mesh = std::move(request.mesh);
    return inputs_[who].countDropped();
  }
  const bool may_replace = isLastReplaceable(who);
  request.waits_for_transforms = may_replace && gate_.must_wait(who, request);
  if (!may_replace || request.waits_for_transforms) {
    return append(&entry, std::move(request), now);
  }
  // The new request takes the old one's share of the rate.
  queue.back() = std::move(request);
  inputs_[who].countDropped();
}

// A request that is late by less than a period does not put off those after it. Otherwise meshes
// that come at exactly the highest rate would fall behind it more and more.
void CycleScheduler::append(Entry* entry, CycleRequest request, SteadyTime now) {
  entry->queue.push_back(std::move(request));
  const bool is_punctual = now - entry->earliest < entry->period;
  entry->earliest = (is_punctual ? entry->earliest : now) + entry->period;
}

// It may be costly to find out who is ready (transforms are looked up), so the one whose turn it is
// is asked first, and then only those with the same stamp.
std::vector<std::size_t> CycleScheduler::next(SteadyTime now, const ros::Time& ros_time) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (hasRequest(i)) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
    return entries_[a].last_turn < entries_[b].last_turn;
  });
  const auto is_ready = [&](std::size_t who) { return isReady(who, now, ros_time); };
  const auto chosen = std::find_if(order.begin(), order.end(), is_ready);
  if (chosen == order.end()) return {};
  std::vector<std::size_t> together{*chosen};
  if (overran(*chosen)) return together;
  for (auto other = chosen + 1; other != order.end(); ++other) {
    const bool same_stamp = first(*other).stamp == first(*chosen).stamp;
    if (same_stamp && !overran(*other) && is_ready(*other)) together.push_back(*other);
  }
  std::sort(together.begin(), together.end());
  return together;
}

// Returns whether the first request has all transforms that may still come, or has waited long
// enough. A request whose time is over although it had its transforms shows that the detector is
// too slow for all meshes. It is dropped if the next one has its transforms too.
bool CycleScheduler::isReady(std::size_t who, SteadyTime now, const ros::Time& ros_time) {
  if (isRobot(who)) return true;
  std::deque<CycleRequest>& queue = entries_[who].queue;
  while (queue.size() > 1 && queue[0].wait.isOver(now, ros_time) &&
         !gate_.must_wait(who, queue[1])) {
    dropFirst(who);
  }
  if (!gate_.must_wait(who, queue.front())) return true;
  for (CycleRequest& request : queue) request.waits_for_transforms = true;
  if (!queue.front().wait.isOver(now, ros_time)) return false;
  gate_.give_up(who, queue.front());
  return true;
}

// All drops from a queue are counted at the object's input, together with those before acceptance.
void CycleScheduler::dropFirst(std::size_t object) {
  entries_[object].queue.pop_front();
  inputs_[object].countDropped();
}

void CycleScheduler::start(const std::vector<std::size_t>& who) {
  ++turns_;
  for (const std::size_t i : who) {
    entries_[i].queue.pop_front();
    entries_[i].last_turn = turns_;
  }
}

void CycleScheduler::finish(const std::vector<std::size_t>& who, bool overran) {
  for (const std::size_t i : who) entries_[i].overran = overran;
}

void CycleScheduler::drop(std::size_t who) {
  while (!isRobot(who) && hasRequest(who)) dropFirst(who);
  entries_[who].queue.clear();  // the robot's own requests have no mesh to count
}

void CycleScheduler::clear() {
  for (std::size_t who = 0; who < entries_.size(); ++who) {
    drop(who);
    entries_[who].overran = false;
  }
}

bool CycleScheduler::isEmpty() const {
  return std::all_of(entries_.begin(), entries_.end(),
                     [](const Entry& entry) { return entry.queue.empty(); });
}

}  // namespace deformable_contact_monitor
