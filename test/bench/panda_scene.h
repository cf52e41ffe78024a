// A robot against a cloth, for the benchmarks.
#pragma once

#include "core/scene.h"

namespace deformable_contact_monitor {

// The Panda's collision meshes, all joints at zero, and, as body 0, a cloth of so many squares each
// way, 15 138 triangles, laid through hand and elbow; links against cloth.
Scene pandaAndCloth(int squares = 87);

// The same with a step: links turn by 0.02 rad about the robot's axis, the cloth falls by 3 mm and
// ripples.
Scene movingPandaAndCloth();

}  // namespace deformable_contact_monitor
