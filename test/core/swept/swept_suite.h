// Detectors that know swept motion, and scenes with a step: every TEST_P of the swept suite runs on
// each of them.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "test/core/detector_suite.h"

namespace deformable_contact_monitor {

// What users get. Once the CUDA backend knows swept motion: productBackends().
inline std::vector<Backend> sweptProductBackends() {
  return {{"cpu", [] { return makeCpuDetector(); }}};
}

// And brute force, for small scenes only.
inline std::vector<Backend> sweptBackends() {
  std::vector<Backend> backends = sweptProductBackends();
  backends.push_back({"brute_force", makeBruteForceDetector});
  return backends;
}

inline Options sweptOptions(AdjacentPairs adjacent = AdjacentPairs::kBeyondShared) {
  Options options = withAdjacent(adjacent);
  options.motion = Motion::kSwept;
  return options;
}

// Where the bodies were at the beginning of their step, as a scene at one moment.
inline Scene sceneBefore(const Scene& scene) {
  Scene before = scene;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const std::optional<EarlierState>& earlier = scene.body(id).earlier;
    if (!earlier) continue;
    before.setPose(id, earlier->pose);
    if (!earlier->vertices.empty()) {
      before.setVertices(id, earlier->vertices.data(), earlier->vertices.size() / 3);
    }
    before.clearEarlier(id);
  }
  return before;
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
