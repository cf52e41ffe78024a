// What the cycles before used: where the steps of swept motion begin.
#include "monitor/cycle/earlier_states.h"

#include <utility>

namespace deformable_contact_monitor {

UsedCycle usedCycle(const ros::Time& stamp, std::uint64_t cycle, const MonitorScene& scene) {
  UsedCycle used{stamp, cycle, {}};
  used.bodies.resize(scene.bodies().size());
  for (BodyId id = 0; id < used.bodies.size(); ++id) {
    const BodyStatus& body = scene.bodies()[id];
    if (body.stamp.isZero() || !body.unknown_because.empty()) continue;
    const AcceptedMesh* const mesh = scene.loadedMesh(id);
    used.bodies[id] =
        UsedBody{body.stamp, scene.scene().body(id).pose, mesh ? *mesh : AcceptedMesh()};
  }
  return used;
}

void EarlierStates::keep(std::size_t who, std::shared_ptr<const UsedCycle> used) {
  slots_[who] = {std::move(used), ""};
}

void EarlierStates::forget(std::size_t who, const std::string& why) {
  slots_[who] = {nullptr, why};
}

void EarlierStates::forgetAll(const std::string& why) {
  for (Slot& slot : slots_) slot = {nullptr, why};
}

}  // namespace deformable_contact_monitor
