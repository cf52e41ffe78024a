// Whose cycle is next: objects take turns, so that none starves beside a faster or an earlier one.
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// One thread at a time. Reads no clock.
class CycleTurns {
 public:
  // What waits for its cycle.
  struct Waiting {
    ros::Time stamp;     // of the cycle
    SteadyTime arrival;  // of the mesh that asked for it
    SteadyTime give_up;  // when it goes ahead without the transforms that it waits for
  };

  // One who takes turns for each rate [Hz], which is the most that it gets; 0: no limit.
  explicit CycleTurns(const std::vector<double>& max_rates_hz);

  // As many as at first. They hold from the last turn of each on.
  void setRates(const std::vector<double>& max_rates_hz);

  // Whether nothing of `who` waits, and its rate allows another cycle.
  bool mayWait(std::size_t who, SteadyTime now) const;
  void wait(std::size_t who, const Waiting& waiting) { entries_[who].waiting = waiting; }
  // What waits of it, if something does, has no turn.
  void drop(std::size_t who) { entries_[who].waiting.reset(); }
  const std::optional<Waiting>& waiting(std::size_t who) const { return entries_[who].waiting; }

  bool anyWaits() const;

  // The one among those that wait and are ready whose last turn is the longest ago, with all others
  // ready for the same stamp, ascending; empty: nobody is. Who overran shares with nobody.
  std::vector<std::size_t> next(const std::function<bool(std::size_t)>& is_ready) const;

  // They have their turn: what waited is gone.
  void start(const std::vector<std::size_t>& who, SteadyTime now);

  // Whether the turn that they had ran out of time. It costs them alone, from their next turn on.
  void finish(const std::vector<std::size_t>& who, bool overran);
  bool overran(std::size_t who) const { return entries_[who].overran; }

  // Nothing waits any more, and all is forgiven.
  void clear();

  // When the rate allows the next cycle of `who`.
  SteadyTime earliest(std::size_t who) const { return entries_[who].earliest; }
  std::size_t count() const { return entries_.size(); }

 private:
  struct Entry {
    SteadyTime::duration period{};
    std::optional<Waiting> waiting;
    SteadyTime earliest;
    std::uint64_t last_turn = 0;
    bool overran = false;
  };

  std::vector<Entry> entries_;
  std::uint64_t turns_ = 0;
};

}  // namespace deformable_contact_monitor
