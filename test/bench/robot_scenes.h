// Robots against cloths, for the benchmarks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// The Panda's collision meshes, all joints at zero, and, as body 0, a cloth of so many squares each
// way, 15 138 triangles, laid through hand and elbow; links against cloth.
Scene pandaAndCloth(int squares = 87);

// Poses of the Panda's links, bodies 1 and on, state by state as StateBatch has them.
struct PandaStates {
  std::vector<BodyId> moved;
  std::vector<RigidTransform> poses;
};

// Returns states whose joints are anywhere within their limits.
PandaStates pandaStates(std::size_t count, std::uint32_t seed);

// The same scene with a step: links turn by 0.02 rad about the robot's axis, the cloth falls by 3
// mm and ripples.
Scene movingPandaAndCloth();

// The PR2's collision meshes, all joints at zero: arms stretched out forwards. As body 0 a blanket
// of 45 000 triangles at this height, 0.95 m being just above the arms; links against blanket.
Scene pr2AndBlanket(float height_m);

}  // namespace deformable_contact_monitor
