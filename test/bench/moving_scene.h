// Input that moves, for the benchmarks.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// A scene of which body 0 moves between two states.
struct MovingScene {
  std::string name;
  Scene scene;
  std::vector<float> state[2];

  void show(int i) { scene.setVertices(0, state[i % 2].data(), state[i % 2].size() / 3); }
};

// The second state is the scene's, 2 mm higher.
inline MovingScene movedUp(const std::string& name, Scene scene) {
  const std::vector<float> state = scene.body(0).mesh.vertices;
  MovingScene moving{name, std::move(scene), {state, state}};
  for (std::size_t i = 2; i < state.size(); i += 3) moving.state[1][i] += 0.002F;
  return moving;
}

}  // namespace deformable_contact_monitor
