// Detectors that know swept motion, and scenes with a step: every TEST_P of the swept suite runs on
// each of them.
#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "test/core/detector_suite.h"

namespace deformable_contact_monitor {

// Returns the backends that users get.
inline std::vector<Backend> sweptProductBackends() { return productBackends(); }

// And brute force, for small scenes only.
inline std::vector<Backend> sweptBackends() { return allBackends(); }

inline Options sweptOptions(AdjacentPairs adjacent = AdjacentPairs::kBeyondShared) {
  Options options = withAdjacent(adjacent);
  options.motion = Motion::kSwept;
  return options;
}

inline Options timedOptions(AdjacentPairs adjacent = AdjacentPairs::kBeyondShared) {
  Options options = sweptOptions(adjacent);
  options.first_times = true;
  return options;
}

inline RigidTransform translationBy(double x, double y, double z) {
  RigidTransform pose;
  pose.translation[0] = x;
  pose.translation[1] = y;
  pose.translation[2] = z;
  return pose;
}

// The body's vertices, each moved by up to `reach` [m] along each axis.
inline std::vector<float> shaken(const TriangleMesh& mesh, float reach, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<float> xyz = mesh.vertices;
  for (float& x : xyz) x += reach * (static_cast<float>(random() % 2001) / 1000 - 1);
  return xyz;
}

}  // namespace deformable_contact_monitor
