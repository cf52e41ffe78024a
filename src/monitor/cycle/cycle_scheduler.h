// Decides whose cycle is next, how long a mesh waits for its transforms, and which meshes have no
// cycle.
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "core/steady_time.h"
#include "monitor/cycle/cycle_clock.h"
#include "monitor/input/mesh_input.h"

namespace deformable_contact_monitor {

// A cycle that waits for its turn.
struct CycleRequest {
  // The mesh that asks for the cycle: accepted or rejected. Without a message it is the robot that
  // asks.
  IncomingMesh mesh;
  ros::Time stamp;  // of the cycle
  Wait wait;        // at its end, the cycle goes ahead without transforms that are late
  bool waits_for_transforms = false;
};

// The scheduler's view of the transforms that a cycle needs.
struct TransformGate {
  // Returns whether transforms that this cycle of the object needs are late, but may still come.
  std::function<bool(std::size_t object, const CycleRequest& request)> must_wait;
  // Notes that the cycle goes ahead without them, so that nobody waits for them again.
  std::function<void(std::size_t object, const CycleRequest& request)> give_up;
};

// Round-robin scheduling over the objects and the robot's own cycles, so that none starves beside a
// faster one. Each has a queue, as meshes may have to wait for transforms. The stamps of a queue
// ascend, so its first mesh is the first to have its transforms.
//
// `who` is the index of an object, or the number of objects for the robot. One thread at a time.
// Reads no clock.
class CycleScheduler {
 public:
  static constexpr std::size_t kMostWaiting = 16;  // of one queue; MeshInput keeps twice as many

  // The inputs must outlive this. `max_rates_hz` holds the highest rate of cycles for each object
  // and then for the robot [Hz]; 0: no limit.
  CycleScheduler(const std::vector<double>& max_rates_hz, MeshInputs& inputs, TransformGate gate);

  // Replaces the rates. They count from the last request of each queue on.
  void setRates(const std::vector<double>& max_rates_hz);

  // Returns whether a request may be added: the queue has room and the rate allows it, or the last
  // request of the queue may be replaced.
  bool mayAdd(std::size_t who, SteadyTime now) const;

  // Queues a request. A mesh that waits for transforms has its cycle when they come, however many
  // meshes come after it. A mesh that waits only for its turn makes way for the next mesh, if that
  // one has its transforms already. Of two meshes with one stamp, the newer has the cycle.
  // Meshes that the input has forgotten since (MeshInput::has) have no cycle. All dropped meshes
  // are counted at the input.
  void add(std::size_t who, CycleRequest request, SteadyTime now);

  // Returns who has the next cycle: the one whose last cycle is the longest ago among those that
  // are ready, with all others that are ready for the same stamp, ascending. Who ran out of time in
  // its last cycle does not share one. Empty: nobody is ready. `ros_time` is that of the waits.
  std::vector<std::size_t> next(SteadyTime now, const ros::Time& ros_time);

  // Removes the first request of each of them from its queue, as their cycle begins.
  void start(const std::vector<std::size_t>& who);
  // Notes whether their cycle ran out of time.
  void finish(const std::vector<std::size_t>& who, bool overran);
  // Returns whether the last cycle of `who` ran out of time.
  bool overran(std::size_t who) const { return entries_[who].overran; }

  // Drop all requests of one queue, or of all of them, and count their meshes at the inputs as
  // dropped. clear() also forgets who ran out of time.
  void drop(std::size_t who);
  void clear();

  bool isEmpty() const;  // no request waits
  bool hasRequest(std::size_t who) const { return !entries_[who].queue.empty(); }
  // Returns the first request of a queue, which must not be empty.
  const CycleRequest& first(std::size_t who) const { return entries_[who].queue.front(); }
  // Returns when the rate allows the next request.
  SteadyTime earliest(std::size_t who) const { return entries_[who].earliest; }

 private:
  struct Entry {
    SteadyTime::duration period{};
    std::deque<CycleRequest> queue;
    SteadyTime earliest;
    std::uint64_t last_turn = 0;
    bool overran = false;
  };

  bool isRobot(std::size_t who) const { return who == inputs_.size(); }
  bool isLastReplaceable(std::size_t who) const;
  bool isReady(std::size_t who, SteadyTime now, const ros::Time& ros_time);
  void append(Entry* entry, CycleRequest request, SteadyTime now);
  void dropFirst(std::size_t object);

  MeshInputs& inputs_;
  const TransformGate gate_;
  std::vector<Entry> entries_;  // by `who`
  std::uint64_t turns_ = 0;
};

}  // namespace deformable_contact_monitor
