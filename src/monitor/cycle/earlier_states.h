// What the cycles before used: where the steps of swept motion begin.
#pragma once

#include <ros/time.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/rigid_transform.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/input/mesh_input.h"

namespace deformable_contact_monitor {

// Where a body was in a cycle.
struct UsedBody {
  ros::Time stamp;      // of its data
  RigidTransform pose;  // of its frame
  AcceptedMesh mesh;    // null: a link
};

// What a cycle used.
struct UsedCycle {
  ros::Time stamp;
  std::uint64_t cycle = 0;                      // its number
  std::vector<std::optional<UsedBody>> bodies;  // by BodyId; nothing: not known in it
};

// As prepare() left it.
UsedCycle usedCycle(const ros::Time& stamp, std::uint64_t cycle, const MonitorScene& scene);

// The previous cycle of each object, and of the robot behind them. One thread at a time.
class EarlierStates {
 public:
  explicit EarlierStates(std::size_t objects) : slots_(objects + 1) {}

  // Null: there is none to start from; why() says so.
  const std::shared_ptr<const UsedCycle>& of(std::size_t who) const { return slots_[who].used; }
  const std::string& why(std::size_t who) const { return slots_[who].why; }

  // It was the cycle of `who`.
  void keep(std::size_t who, std::shared_ptr<const UsedCycle> used);
  void forget(std::size_t who, const std::string& why);
  void forgetAll(const std::string& why);

 private:
  struct Slot {
    std::shared_ptr<const UsedCycle> used;
    std::string why = "its first cycle";
  };

  std::vector<Slot> slots_;
};

}  // namespace deformable_contact_monitor
