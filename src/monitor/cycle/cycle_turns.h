// Whose cycle is next: objects take turns, so that none starves beside a faster or an earlier one.
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Each has a queue, as meshes may have to wait for transforms. One thread at a time. Reads no
// clock.
class CycleTurns {
 public:
  // What waits for its cycle.
  struct Waiting {
    ros::Time stamp;       // of the cycle
    SteadyTime arrival;    // of the mesh that asked for it
    SteadyTime give_up;    // when it goes ahead without the transforms that it waits for
    bool held_up = false;  // it had to wait for transforms, not for its turn alone
  };
  using Queue = std::deque<Waiting>;  // the first is next

  static constexpr std::size_t kMostWaiting = 16;  // of each; meshes are kept for twice as many

  // One who takes turns for each rate [Hz], which is the most that it gets; 0: no limit.
  explicit CycleTurns(const std::vector<double>& max_rates_hz);

  // As many as at first. They hold from the last one that waits of each on.
  void setRates(const std::vector<double>& max_rates_hz);

  const Queue& waiting(std::size_t who) const { return entries_[who].waiting; }
  bool anyWaits() const;

  // Whether another one may wait: the queue has room, and the rate allows it, or the last one of
  // the queue waits for its turn alone and may be replaced.
  bool mayWait(std::size_t who, SteadyTime now) const;
  // Whether the last one of the queue waits for its turn alone, so that a newer one may replace it.
  bool isLastReplaceable(std::size_t who) const;

  // To the end of the queue.
  void wait(std::size_t who, const Waiting& waiting, SteadyTime now);
  // In place of the last one, whose share of the rate it takes.
  void replaceLast(std::size_t who, const Waiting& waiting);
  // All of the queue wait for transforms.
  void holdUp(std::size_t who);
  void dropFirst(std::size_t who) { entries_[who].waiting.pop_front(); }
  // Nothing of it waits any more.
  void drop(std::size_t who) { entries_[who].waiting.clear(); }

  // The one among those that wait and are ready whose last turn is the longest ago, with all others
  // ready for the same stamp, ascending; empty: nobody is. Asked of the first of each queue. Who
  // overran shares with nobody.
  std::vector<std::size_t> next(const std::function<bool(std::size_t)>& is_ready) const;

  // They have their turn: the first of each queue is gone.
  void start(const std::vector<std::size_t>& who);

  // Whether the turn that they had ran out of time. It costs them alone, from their next turn on.
  void finish(const std::vector<std::size_t>& who, bool overran);
  bool overran(std::size_t who) const { return entries_[who].overran; }

  // Nothing waits any more, and all is forgiven.
  void clear();

  // When the rate allows another one of `who` to wait.
  SteadyTime earliest(std::size_t who) const { return entries_[who].earliest; }
  std::size_t count() const { return entries_.size(); }

 private:
  struct Entry {
    SteadyTime::duration period{};
    Queue waiting;
    SteadyTime earliest;
    std::uint64_t last_turn = 0;
    bool overran = false;
  };

  std::vector<Entry> entries_;
  std::uint64_t turns_ = 0;
};

}  // namespace deformable_contact_monitor
