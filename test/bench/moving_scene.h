// Input that moves, for the benchmarks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdlib>
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

// Divides body 0 into as many parts as $DCM_BENCH_PARTS says, in runs of triangles, and disables
// the first of them against the second one and against all of body 1, so that parts matter. Without
// that variable it does nothing.
inline void divideIntoParts(MovingScene& moving) {
  const char* const given = std::getenv("DCM_BENCH_PARTS");
  if (given == nullptr) return;
  const std::size_t count = moving.scene.body(0).mesh.triangleCount();
  const std::size_t parts = std::strtoul(given, nullptr, 10);
  std::vector<PartId> part_of_triangle(count);
  for (std::size_t t = 0; t < count; ++t) {
    part_of_triangle[t] = static_cast<PartId>(t * parts / count + 1);
  }
  moving.scene.setParts(0, part_of_triangle);
  moving.scene.setPartPairEnabled(0, 1, 0, 2, false);
  if (moving.scene.bodyCount() > 1) moving.scene.setPartPairEnabled(0, 1, 1, 0, false);
  moving.name += ", " + std::to_string(parts) + " parts";
}

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
