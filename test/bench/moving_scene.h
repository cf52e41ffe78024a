// Input that moves, for the benchmarks.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// A scene of which body 0 moves between two states, and those after it too if they have poses.
struct MovingScene {
  std::string name;
  Scene scene;
  std::vector<float> state[2];
  std::array<std::vector<RigidTransform>, 2> poses = {};  // of the bodies from 1 on

  void show(int i) {
    scene.setVertices(0, state[i % 2].data(), state[i % 2].size() / 3);
    BodyId body = 1;
    for (const RigidTransform& pose : poses[i % 2]) scene.setPose(body++, pose);
  }
};

// The second state is the scene's, 2 mm higher.
inline MovingScene movedUp(const std::string& name, Scene scene) {
  const std::vector<float> state = scene.body(0).mesh.vertices;
  MovingScene moving{name, std::move(scene), {state, state}};
  for (std::size_t i = 2; i < state.size(); i += 3) moving.state[1][i] += 0.002F;
  return moving;
}

// The other bodies too, by as much.
inline MovingScene allMovedUp(const std::string& name, Scene scene) {
  MovingScene moving = movedUp(name, std::move(scene));
  for (BodyId body = 1; body < moving.scene.bodyCount(); ++body) {
    for (std::vector<RigidTransform>& poses : moving.poses) {
      poses.push_back(moving.scene.body(body).pose);
    }
    moving.poses[1].back().translation[2] += 0.002;
  }
  return moving;
}

}  // namespace deformable_contact_monitor
